#include "scheduler/listen/listen_address.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>

#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {

constexpr std::string_view kUnix = "unix:";

// Whether a server answers at this socket.
bool is_live(const std::string& path) {
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  if (path.size() >= sizeof name.sun_path)
    throw InputError(fmt::format("unix:{}: is {} bytes long, expected less than {}", path,
                                 path.size(), sizeof name.sun_path));
  path.copy(name.sun_path, path.size());
  const int probe = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (probe < 0) throw InputError(fmt::format("unix:{}: {}", path, std::strerror(errno)));
  const int result = connect(probe, reinterpret_cast<const sockaddr*>(&name), sizeof name);
  const int error = errno;
  close(probe);
  return result == 0 || error != ECONNREFUSED;
}

}  // namespace

std::optional<std::filesystem::path> socket_path(const std::string& address) {
  if (!address.starts_with(kUnix)) return std::nullopt;
  std::string path = address.substr(kUnix.size());
  if (path.starts_with("//")) path.erase(0, 2);  // "unix:///path" names the same.
  return path;
}

void check_listen_address(const std::string& address) {
  if (const auto path = socket_path(address)) {
    if (path->empty())
      throw UsageError(fmt::format("{}: found no path, expected unix:/path", address));
    return;
  }
  const size_t colon = address.rfind(':');
  const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
  int number = -1;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  if (colon == 0 || colon == std::string::npos || error != std::errc() ||
      end != port.data() + port.size() || number < 0 || number > 65535)
    throw UsageError(
        fmt::format("{}: expected host:port with a port from 0 to 65535, or unix:/path", address));
}

SocketClaim::SocketClaim(const std::string& address) {
  if (!socket_path(address)) return;
  const std::filesystem::path path = *socket_path(address);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  folder_ = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_ < 0)
    throw InputError(fmt::format("{}: {}: {}", address, folder.string(), std::strerror(errno)));
  flock(folder_, LOCK_EX);
  struct stat status {};
  if (lstat(path.c_str(), &status) != 0) return;
  std::string refused;
  if (!S_ISSOCK(status.st_mode))
    refused = "exists and is no socket, expected a free name";
  else if (is_live(path.string()))
    refused = "another server listens there";
  else if (unlink(path.c_str()) != 0)
    refused =
        fmt::format("a socket that was left there cannot be removed: {}", std::strerror(errno));
  if (refused.empty()) return;
  close(folder_);
  throw InputError(fmt::format("{}: {}", address, refused));
}

SocketClaim::~SocketClaim() {
  if (folder_ >= 0) close(folder_);
}

}  // namespace seam::scheduler
