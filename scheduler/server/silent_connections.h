// For tests: TCP connections that say nothing.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace seam::scheduler::testing {

// The soft limit of descriptors with which most systems start a program, given back at the end.
class UsualDescriptorLimit {
 public:
  UsualDescriptorLimit() {
    getrlimit(RLIMIT_NOFILE, &before_);
    rlimit usual = before_;
    usual.rlim_cur = 1024;
    setrlimit(RLIMIT_NOFILE, &usual);
  }
  ~UsualDescriptorLimit() { setrlimit(RLIMIT_NOFILE, &before_); }
  bool can_be_raised_to(rlim_t count) const { return before_.rlim_max >= count; }

 private:
  rlimit before_{};
};

class SilentConnections {
 public:
  // "127.0.0.1:port".
  SilentConnections(const std::string& address, int count) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    for (int i = 0; i < count; ++i) {
      const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      if (fd < 0) break;
      if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
        all_.push_back(fd);
      else
        close(fd);
    }
  }
  ~SilentConnections() {
    for (const int fd : all_) close(fd);
  }
  size_t count() const { return all_.size(); }

  // Whether the server hangs up on the first of them within this time.
  bool hung_up_within(int seconds) const {
    char bytes[256];
    for (int i = 0; i < 100; ++i) {
      pollfd wait{.fd = all_.front(), .events = POLLIN, .revents = 0};
      if (poll(&wait, 1, 1000 * seconds) <= 0) return false;
      if (read(all_.front(), bytes, sizeof bytes) <= 0) return true;  // Its settings come first.
    }
    return false;
  }

 private:
  std::vector<int> all_;
};

}  // namespace seam::scheduler::testing
