#include "tools/pages/loopback_host.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace seam::tools {
namespace {

bool is_port(std::string_view text) {
  constexpr int kLargest = 65535;
  int port = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return false;
    port = 10 * port + (c - '0');
    if (port > kLargest) return false;
  }
  return port > 0;
}

}  // namespace

bool names_loopback(std::string_view host) {
  std::string lower(host);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const std::string_view name : {"localhost", "127.0.0.1", "[::1]"}) {
    if (!lower.starts_with(name)) continue;
    const std::string_view rest = std::string_view(lower).substr(name.size());
    return rest.empty() || (rest.front() == ':' && is_port(rest.substr(1)));
  }
  return false;
}

}  // namespace seam::tools
