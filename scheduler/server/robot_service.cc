// The robots' streams by gRPC: one session a stream.
#include <grpcpp/grpcpp.h>

#include "scheduler/server/robot_session.h"
#include "scheduler/server/services.h"
#include "scheduler/server/stream.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace seam::scheduler {

namespace {

class StreamSession final : public Stream<v1::ClientMessage, v1::ServerMessage>,
                            public RobotSession {
 public:
  using RobotSession::RobotSession;

 private:
  // ---- Stream ----
  void take(const v1::ClientMessage& message) override {
    const size_t bytes = message.ByteSizeLong();
    bytes > size_t{WireLimits::kMaxMessageBytes} ? take_too_long(bytes) : take_message(message);
  }
  void leave() override { client_left(); }
  bool greeted() override { return has_greeted(); }
  // ---- RobotSession ----
  void say(v1::ServerMessage message) override { write(std::move(message)); }
  void hang_up(const grpc::Status& status) override { end(status); }
  std::shared_ptr<ClientConnection> self() override {
    return std::static_pointer_cast<StreamSession>(shared_from_this());
  }
};

class RobotService final : public v1::Simulation::CallbackService {
 public:
  explicit RobotService(const SessionParts& parts) : parts_(parts) {}

  grpc::ServerBidiReactor<v1::ClientMessage, v1::ServerMessage>* Drive(
      grpc::CallbackServerContext* context) override {
    const auto session = std::make_shared<StreamSession>(parts_, peer_of(context->peer()));
    session->start();
    return session.get();
  }

 private:
  const SessionParts& parts_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_robot_service(const SessionParts& parts) {
  return std::make_unique<RobotService>(parts);
}

}  // namespace seam::scheduler
