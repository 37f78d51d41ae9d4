// What a server shows and asks of its clients by TLS.
#pragma once

#include <string>

namespace seam::scheduler {

// PEM texts. Clients must show a certificate that the same CA signed.
struct TlsTexts {
  std::string ca;
  std::string certificate;
  std::string key;
};

}  // namespace seam::scheduler
