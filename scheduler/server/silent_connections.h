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
  // "127.0.0.1:port"; `from`: another address of this machine to come from.
  SilentConnections(const std::string& address, int count, const std::string& from = "127.0.0.1")
      : SilentConnections(count) {
    open_all(address, from);
  }
  // Sockets that connect later: then this process needs no descriptors for them.
  explicit SilentConnections(int count) {
    for (int i = 0; i < count; ++i)
      if (const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0); fd >= 0)
        sockets_.push_back(fd);
  }
  void open_all(const std::string& address, const std::string& from = "127.0.0.1") {
    sockaddr_in to{}, own{};
    to.sin_family = own.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    inet_pton(AF_INET, from.c_str(), &own.sin_addr);
    for (const int fd : sockets_)
      if (bind(fd, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0 &&
          connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0)
        all_.push_back(fd);
  }
  ~SilentConnections() {
    for (const int fd : sockets_) close(fd);
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

  // What the server says to the last of them until it hangs up, at most for this time.
  std::string last_words(int seconds) const {
    std::string words;
    char bytes[256];
    pollfd wait{.fd = all_.back(), .events = POLLIN, .revents = 0};
    while (poll(&wait, 1, 1000 * seconds) > 0) {
      const ssize_t got = read(all_.back(), bytes, sizeof bytes);
      if (got <= 0) break;
      words.append(bytes, static_cast<size_t>(got));
    }
    return words;
  }

 private:
  std::vector<int> sockets_;
  std::vector<int> all_;  // Of them: connected.
};

}  // namespace seam::scheduler::testing
