#include "scheduler/server/direct_line.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <utility>

#include "scheduler/wire/wire.h"

namespace seam::scheduler {
namespace {

// Of a decision that is refused for its length. Whoever sends more than this is hung up on.
constexpr size_t kMostSkippedBytes = 64 << 20;

pid_t process_at(int socket) {
  ucred who{};
  socklen_t size = sizeof who;
  return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 ? who.pid : 0;
}

}  // namespace

DirectLine::DirectLine(const SessionParts& parts, std::string peer, int socket)
    : RobotSession(parts, std::move(peer)),
      socket_(socket),
      process_(process_at(socket)),
      incoming_(WireLimits::kMaxMessageBytes, kMostSkippedBytes) {}

DirectLine::~DirectLine() {
  ::close(socket_);
}

bool DirectLine::wants_to_write() const {
  const std::lock_guard lock(writing_);
  return !unwritten_.empty() && !broken_;
}

bool DirectLine::is_over() const {
  const std::lock_guard lock(writing_);
  return broken_ || (ended_ && unwritten_.empty());
}

void DirectLine::serve() {
  const std::lock_guard lock(reading_);
  write_what_waits();
  auto received = LineFrames::Received::bytes;
  // A client that sends but never reads is not read from further.
  while (received == LineFrames::Received::bytes && !wants_to_write() && !is_over()) {
    take_frames();
    if (!is_over()) received = incoming_.receive(socket_, MSG_DONTWAIT);
  }
  {
    const std::lock_guard writing(writing_);
    broken_ = broken_ || received == LineFrames::Received::closed;
    if (!broken_) return;
  }
  client_left();
}

void DirectLine::take_frames() {
  try {
    while (const auto frame = incoming_.next()) {
      if (frame->skipped_bytes > 0) {
        take_too_long(frame->skipped_bytes);
        continue;
      }
      if (frame->is_end ||
          !message_.ParseFromArray(frame->bytes.data(), static_cast<int>(frame->bytes.size())))
        return hang_up({grpc::StatusCode::INTERNAL, "found bytes that are no message"});
      take_message(message_);
    }
  } catch (const std::length_error& error) {
    hang_up({grpc::StatusCode::RESOURCE_EXHAUSTED, error.what()});
  }
}

void DirectLine::say(v1::ServerMessage message) {
  write(line_frame(message), false);
}

void DirectLine::hang_up(const grpc::Status& status) {
  write(line_end(status.error_code(), status.error_message()), true);
}

void DirectLine::write(const std::string& bytes, bool last) {
  {
    const std::lock_guard lock(writing_);
    if (ended_ || broken_) return;
    unwritten_ += bytes;
    ended_ = last;
  }
  write_what_waits();
}

void DirectLine::write_what_waits() {
  const std::lock_guard lock(writing_);
  size_t written = 0;
  while (written < unwritten_.size() && !broken_) {
    const ssize_t sent = ::send(socket_, unwritten_.data() + written, unwritten_.size() - written,
                                MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0)
      written += static_cast<size_t>(sent);
    else if (errno == EAGAIN || errno == EWOULDBLOCK)
      break;
    else if (errno != EINTR)
      broken_ = true;  // Who serves the line notifies the hub.
  }
  unwritten_.erase(0, written);
}

}  // namespace seam::scheduler
