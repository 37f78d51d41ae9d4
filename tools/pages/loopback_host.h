// What a browser says whom it asks, in the header Host.
#pragma once

#include <string_view>

namespace seam::tools {

// Whether it names this machine by a loopback name (localhost, 127.0.0.1 or [::1], with a port or
// without one). A page of another site that has its own name lead to this machine is recognised so.
bool names_loopback(std::string_view host);

}  // namespace seam::tools
