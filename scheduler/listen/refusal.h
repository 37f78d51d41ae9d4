// What a server says to a connection that it cannot take, in the words of the protocol that the
// client expects, before it hangs up.
#pragma once

#include <string>
#include <string_view>

namespace seam::scheduler {

// Settings and GOAWAY with ENHANCE_YOUR_CALM and the reason (RFC 9113, 6.5 and 6.8). At most 200
// bytes of the reason.
std::string http2_refusal(std::string_view why);
// The fatal alert access_denied before any handshake (RFC 8446, 6.2): no reason can be given there.
std::string tls_refusal();
// The end of a direct line (proto/line.h), with the code of one that may be tried again.
std::string line_refusal(std::string_view why);

}  // namespace seam::scheduler
