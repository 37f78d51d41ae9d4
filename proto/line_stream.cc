#include "proto/line_stream.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "proto/client_channel.h"

namespace seam {

LineStream::LineStream(const std::string& path) : incoming_(kMaxServerMessageBytes) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() < sizeof address.sun_path) {
    path.copy(address.sun_path, path.size());
    socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  }
  if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0)
    break_off(std::strerror(errno));
}

LineStream::~LineStream() {
  if (socket_ >= 0) ::close(socket_);
}

bool LineStream::Write(const v1::ClientMessage& message) {
  if (!status_.ok()) return false;
  const std::string frame = line_frame(message);
  for (size_t written = 0; written < frame.size();) {
    const ssize_t sent =
        ::send(socket_, frame.data() + written, frame.size() - written, MSG_NOSIGNAL);
    // Whoever hung up may have said why before: Read finds it.
    if (sent < 0 && errno != EINTR) return true;
    if (sent > 0) written += static_cast<size_t>(sent);
  }
  return true;
}

bool LineStream::Read(v1::ServerMessage* message) {
  while (status_.ok()) {
    try {
      if (const auto frame = incoming_.next()) {
        if (frame->is_end) {
          status_ = {static_cast<grpc::StatusCode>(frame->code), std::string(frame->bytes)};
          return false;
        }
        return message->ParseFromArray(frame->bytes.data(),
                                       static_cast<int>(frame->bytes.size())) ||
               break_off("found bytes that are no message");
      }
    } catch (const std::length_error& error) {
      return break_off(error.what());
    }
    if (incoming_.receive(socket_, 0) != LineFrames::Received::bytes)
      return break_off("the connection broke");
  }
  return false;
}

bool LineStream::break_off(const char* why) {
  status_ = {grpc::StatusCode::UNAVAILABLE, why};
  return false;
}

}  // namespace seam
