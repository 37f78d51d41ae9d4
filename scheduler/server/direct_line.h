// A robot's session on a direct line (proto/line.h). Between turns DirectLines watches it; while
// its robot owes a decision the loop's own thread reads it, so that no other thread need wake up.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "proto/line.h"
#include "scheduler/server/robot_session.h"

namespace seam::scheduler {

class DirectLine final : public RobotSession, public std::enable_shared_from_this<DirectLine> {
 public:
  // Owns the socket.
  DirectLine(const SessionParts& parts, std::string peer, int socket);
  ~DirectLine() override;

  // ---- ClientConnection ----
  int descriptor() const override { return socket_; }
  pid_t process() const override { return process_; }
  bool wants_to_write() const override;
  // From any thread, one at a time.
  void serve() override;

  // ---- For DirectLines ----
  bool greeted() { return has_greeted(); }
  // Nothing comes any more, and nothing waits to be written.
  bool is_over() const;
  // Ends the session, with a word to the client.
  void close_down(const grpc::Status& status) { hang_up(status); }

 private:
  void say(v1::ServerMessage message) override;
  void hang_up(const grpc::Status& status) override;
  std::shared_ptr<ClientConnection> self() override { return shared_from_this(); }

  void take_frames();
  void write(const std::string& bytes, bool last);
  void write_what_waits();

  const int socket_;
  const pid_t process_;
  std::mutex reading_;  // Taken before the hub's lock; the hub never holds its own when it reads.
  LineFrames incoming_;
  v1::ClientMessage message_;

  mutable std::mutex writing_;  // Taken last.
  std::string unwritten_;
  bool ended_ = false;   // The end is written, or waits to be.
  bool broken_ = false;  // The client is gone.
};

}  // namespace seam::scheduler
