#include "app/predictors/run_helper.h"

#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <optional>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr char kDone = '+', kFailed = '-';

bool send_all(int socket, const char* data, size_t size) {
  while (size > 0) {
    const ssize_t sent = ::send(socket, data, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    data += sent, size -= static_cast<size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, char* data, size_t size) {
  while (size > 0) {
    const ssize_t got = ::recv(socket, data, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    data += got, size -= static_cast<size_t>(got);
  }
  return true;
}

// A length and as many bytes; both ends are of one program, so that nothing is checked.
bool send_text(int socket, const std::string& text) {
  const uint64_t size = text.size();
  return send_all(socket, reinterpret_cast<const char*>(&size), sizeof size) &&
         send_all(socket, text.data(), text.size());
}

std::optional<std::string> receive_text(int socket) {
  uint64_t size = 0;
  if (!receive_all(socket, reinterpret_cast<char*>(&size), sizeof size)) return std::nullopt;
  std::string text(size, '\0');
  if (!receive_all(socket, text.data(), text.size())) return std::nullopt;
  return text;
}

[[noreturn]] void serve(int socket,
                        const std::function<std::string(const std::string& request)>& answer) {
  while (const auto request = receive_text(socket)) {
    std::string text;
    try {
      text = kDone + answer(*request);
    } catch (const std::exception& error) {
      text = kFailed + std::string(error.what());
    }
    if (!send_text(socket, text)) break;
  }
  std::fflush(nullptr);
  ::_exit(0);
}

}  // namespace

RunHelper::RunHelper(const std::function<std::string(const std::string& request)>& answer) {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw InputError("no sockets for the process that makes runs");
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ < 0) throw InputError("cannot start the process that makes runs");
  if (process_ == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(1);
    ::close(ends[0]);
    serve(ends[1], answer);
  }
  ::close(ends[1]);
  socket_ = ends[0];
}

RunHelper::~RunHelper() {
  ::close(socket_);
  ::waitpid(process_, nullptr, 0);
}

std::string RunHelper::ask(const std::string& request) {
  const std::lock_guard lock(mutex_);
  std::optional<std::string> reply;
  if (send_text(socket_, request)) reply = receive_text(socket_);
  if (!reply || reply->empty()) throw InputError("the process that makes runs has ended");
  const std::string text = reply->substr(1);
  if (reply->front() == kFailed) throw InputError(text);
  return text;
}

}  // namespace seam::app
