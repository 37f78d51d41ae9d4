#include "scheduler/listen/connection_count.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>

namespace seam::scheduler {
namespace {

// Looking at each of thousands of descriptors takes a millisecond: who floods a server that is full
// does not make it do so each time.
constexpr std::chrono::milliseconds kLookEvery{100};

std::string shown_address(int family, const void* address) {
  char text[INET6_ADDRSTRLEN] = "";
  inet_ntop(family, address, text, sizeof text);
  return text;
}

}  // namespace

ConnectionLimits connection_limits() {
  ConnectionLimits limits;
  rlimit descriptors{};
  if (getrlimit(RLIMIT_NOFILE, &descriptors) != 0) return limits;
  limits.in_all = std::min<size_t>(limits.in_all, descriptors.rlim_cur / 2);
  limits.by_peer = std::min(limits.by_peer, limits.in_all / 2);
  return limits;
}

std::string peer_of_socket(int connection) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  if (getpeername(connection, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return "unknown";
  if (storage.ss_family == AF_UNIX) {
    ucred who{};
    socklen_t who_size = sizeof who;
    if (getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &who, &who_size) != 0) return "unix";
    return fmt::format("user {}", who.uid);
  }
  if (storage.ss_family == AF_INET)
    return shown_address(AF_INET, &reinterpret_cast<const sockaddr_in&>(storage).sin_addr);
  if (storage.ss_family != AF_INET6) return "unknown";
  in6_addr address = reinterpret_cast<const sockaddr_in6&>(storage).sin6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&address)) return shown_address(AF_INET, address.s6_addr + 12);
  if (IN6_IS_ADDR_LOOPBACK(&address)) return shown_address(AF_INET6, &address);
  std::memset(address.s6_addr + 8, 0, 8);
  return shown_address(AF_INET6, &address) + "/64";
}

bool ConnectionCount::is_full(const std::string& peer) const {
  const auto found = by_peer_.find(peer);
  return all_ >= limits_.in_all ||
         (found != by_peer_.end() && found->second.size() >= limits_.by_peer);
}

void ConnectionCount::forget_closed() {
  all_ = 0;
  for (auto it = by_peer_.begin(); it != by_peer_.end();) {
    std::erase_if(it->second, [](const Socket& socket) {
      struct stat status {};
      return fstat(socket.descriptor, &status) != 0 || !S_ISSOCK(status.st_mode) ||
             status.st_ino != socket.inode;
    });
    all_ += it->second.size();
    it = it->second.empty() ? by_peer_.erase(it) : std::next(it);
  }
}

std::string ConnectionCount::refusal(const std::string& peer, int connection) {
  if (is_full(peer) && now_() - looked_ >= kLookEvery) {
    looked_ = now_();
    forget_closed();
  }
  if (all_ >= limits_.in_all)
    return fmt::format("{} connections stand, the most that this server takes", all_);
  std::vector<Socket>& sockets = by_peer_[peer];
  if (sockets.size() >= limits_.by_peer)
    return fmt::format("{} connections of {} stand, the most that one peer may have",
                       sockets.size(), peer);
  struct stat status {};
  if (fstat(connection, &status) != 0) return "the connection is gone";
  sockets.push_back({connection, status.st_ino});
  ++all_;
  return "";
}

}  // namespace seam::scheduler
