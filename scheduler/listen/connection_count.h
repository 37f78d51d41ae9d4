// How many connections stand, by peer and in all. Whoever took a connection over closes it without
// a word to us, so that the count asks the operating system which descriptors are still the same
// sockets.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace seam::scheduler {

struct ConnectionLimits {
  size_t in_all = 8192;
  size_t by_peer = 4096;
};

// Half of the descriptors that this process may have, and half of that for one peer; at most the
// numbers above.
ConnectionLimits connection_limits();

// Who is at the other end of a connection: an address without its port (of IPv6 the first 64 bits,
// which one subscriber has), or the user behind a Unix socket.
std::string peer_of_socket(int connection);

class ConnectionCount {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ConnectionCount(ConnectionLimits limits,
                           std::function<Clock::time_point()> now = Clock::now)
      : limits_(limits), now_(std::move(now)) {}

  // Counts the connection, until its descriptor is closed. Otherwise why it is refused.
  std::string refusal(const std::string& peer, int connection);
  size_t standing() const { return all_; }  // Some of them may be closed by now.

 private:
  struct Socket {
    int descriptor;
    ino_t inode;
  };
  bool is_full(const std::string& peer) const;
  void forget_closed();

  ConnectionLimits limits_;
  std::function<Clock::time_point()> now_;
  Clock::time_point looked_;
  std::map<std::string, std::vector<Socket>> by_peer_;
  size_t all_ = 0;
};

}  // namespace seam::scheduler
