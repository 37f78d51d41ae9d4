#include "scheduler/listen/listening_socket.h"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "scheduler/listen/listen_address.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

[[noreturn]] void fail(const std::string& address, const std::string& why) {
  throw InputError(fmt::format("{}: cannot listen on this address: {}", address, why));
}

// The descriptor, or -1 with errno.
int bound(const sockaddr* address, socklen_t size) {
  const int socket = ::socket(address->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return -1;
  const int yes = 1;
  // A port whose last connections are fading away is free.
  if (address->sa_family != AF_UNIX) setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (bind(socket, address, size) == 0 && listen(socket, SOMAXCONN) == 0) return socket;
  const int error = errno;
  ::close(socket);
  errno = error;
  return -1;
}

int port_of(int socket) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  getsockname(socket, reinterpret_cast<sockaddr*>(&storage), &size);
  return ntohs(storage.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6&>(storage).sin6_port
                   : reinterpret_cast<const sockaddr_in&>(storage).sin_port);
}

void set_port(sockaddr* address, int port) {
  const in_port_t value = htons(static_cast<uint16_t>(port));
  if (address->sa_family == AF_INET6)
    reinterpret_cast<sockaddr_in6*>(address)->sin6_port = value;
  else
    reinterpret_cast<sockaddr_in*>(address)->sin_port = value;
}

int bound_unix(const std::string& address, const std::string& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (path.size() >= sizeof name.sun_path)
    fail(address, fmt::format("its path has {} bytes, expected less than {}", path.size(),
                              sizeof name.sun_path));
  path.copy(name.sun_path, path.size());
  const SocketClaim claim(address);
  const int socket = bound(reinterpret_cast<const sockaddr*>(&name), sizeof name);
  if (socket < 0) fail(address, std::strerror(errno));
  return socket;
}

}  // namespace

ListeningSocket::ListeningSocket(int descriptor, std::string path)
    : descriptor_(descriptor), path_(std::move(path)) {
  struct stat status {};
  if (fstat(descriptor_, &status) == 0) inode_ = status.st_ino;
  if (path_.empty() || lstat(path_.c_str(), &status) != 0) return;
  path_device_ = status.st_dev;
  path_inode_ = status.st_ino;
}

ListeningSocket::ListeningSocket(ListeningSocket&& other) noexcept {
  *this = std::move(other);
}

ListeningSocket& ListeningSocket::operator=(ListeningSocket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(inode_, other.inode_);
  std::swap(path_, other.path_);
  std::swap(path_device_, other.path_device_);
  std::swap(path_inode_, other.path_inode_);
  return *this;
}

bool ListeningSocket::is_ours() const {
  struct stat status {};
  return descriptor_ >= 0 && fstat(descriptor_, &status) == 0 && S_ISSOCK(status.st_mode) &&
         status.st_ino == inode_;
}

bool ListeningSocket::has_its_name() const {
  struct stat status {};
  return lstat(path_.c_str(), &status) == 0 && status.st_dev == path_device_ &&
         status.st_ino == path_inode_;
}

bool ListeningSocket::lives() const {
  int listens = 0;
  socklen_t size = sizeof listens;
  return is_ours() && getsockopt(descriptor_, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) == 0 &&
         listens != 0 && (path_.empty() || has_its_name());
}

void ListeningSocket::close() noexcept {
  if (!path_.empty() && has_its_name()) unlink(path_.c_str());
  // Its number may be another file's by now.
  if (is_ours()) ::close(descriptor_);
  descriptor_ = -1;
}

std::vector<ListeningSocket> listen_on(const std::string& address, int& port) {
  std::vector<ListeningSocket> sockets;
  if (const auto path = socket_path(address)) {
    port = -1;
    sockets.push_back(ListeningSocket(bound_unix(address, path->string()), path->string()));
    return sockets;
  }
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const addrinfo wanted{.ai_flags = AI_PASSIVE | AI_NUMERICSERV, .ai_socktype = SOCK_STREAM};
  addrinfo* found = nullptr;
  const int unknown = getaddrinfo(host.c_str(), address.substr(colon + 1).c_str(), &wanted, &found);
  if (unknown != 0) fail(address, gai_strerror(unknown));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(found, freeaddrinfo);
  int error = 0;
  port = 0;
  for (addrinfo* one = found; one != nullptr; one = one->ai_next) {
    if (port != 0) set_port(one->ai_addr, port);
    const int socket = bound(one->ai_addr, one->ai_addrlen);
    if (socket < 0) {
      error = errno;
      if (error == EADDRINUSE) fail(address, std::strerror(error));
      continue;  // A name may have an address that this machine has not (IPv6).
    }
    sockets.push_back(ListeningSocket(socket, ""));
    port = port_of(socket);
  }
  if (sockets.empty()) fail(address, std::strerror(error));
  return sockets;
}

}  // namespace seam::scheduler
