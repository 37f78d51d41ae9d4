// Addresses that a server listens on, checked before gRPC sees them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace seam::scheduler {

// Throws UsageError unless it is "unix:/path" or "host:port" with a port from 0 to 65535.
void check_listen_address(const std::string& address);

// The path of a "unix:" address, none for others.
std::optional<std::filesystem::path> socket_path(const std::string& address);

// While a server binds a Unix socket: that of a server that is there is refused, one that a dead
// server left behind is removed, and of two servers that start at once one waits for the other.
class SocketClaim {
 public:
  // Does nothing for other addresses. Throws InputError where the socket cannot be had.
  explicit SocketClaim(const std::string& address);
  ~SocketClaim();
  SocketClaim(const SocketClaim&) = delete;
  SocketClaim& operator=(const SocketClaim&) = delete;

 private:
  int folder_ = -1;  // Locked.
};

}  // namespace seam::scheduler
