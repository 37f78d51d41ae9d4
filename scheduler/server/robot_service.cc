// The robots' streams: one session a stream. A session turns wire messages into calls of the hub;
// nothing that a client sends goes anywhere else.
#include <fmt/format.h>
#include <grpcpp/grpcpp.h>

#include <mutex>

#include "scheduler/loop/clock.h"
#include "scheduler/server/services.h"
#include "scheduler/server/stream.h"
#include "scheduler/wire/wire.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace seam::scheduler {

namespace {

constexpr size_t kMaxClientNameBytes = 200;

class Session final : public Stream<v1::ClientMessage, v1::ServerMessage>, public ClientConnection {
 public:
  Session(const Scenario& scenario, ClientHub& hub, TokenTries& tries, std::string peer)
      : scenario_(scenario), hub_(hub), tries_(tries), peer_(std::move(peer)) {}

  // ---- ClientConnection ----
  void send(std::shared_ptr<const Observation> observation) override {
    v1::ServerMessage message;
    observation_to_wire(*observation, *message.mutable_observation());
    write(std::move(message));
  }
  void say_goodbye(SimTime time, const std::string& reason) override {
    v1::ServerMessage message;
    message.mutable_goodbye()->set_reason(reason);
    message.mutable_goodbye()->set_time_ns(time.ns());
    write(std::move(message));
    end(grpc::Status::OK);
  }
  void drop(const std::string& reason) override { end({grpc::StatusCode::ABORTED, reason}); }

 private:
  // ---- Stream ----
  void take(const v1::ClientMessage& message) override;
  void leave() override;
  bool greeted() override {
    const std::lock_guard lock(mutex_);
    return robot_ >= 0;
  }

  void take_hello(const v1::ClientMessage& message);
  void take_decision(const v1::ClientMessage& message);
  void refuse(uint64_t sequence, const FieldError& error, bool decision_owed);

  const Scenario& scenario_;
  ClientHub& hub_;
  TokenTries& tries_;
  std::string peer_;
  std::mutex mutex_;
  int robot_ = -1;  // Once the hello was accepted.
  bool left_ = false;
};

void Session::take(const v1::ClientMessage& message) {
  if (greeted())
    take_decision(message);
  else
    take_hello(message);
}

void Session::leave() {
  int robot;
  {
    const std::lock_guard lock(mutex_);
    robot = std::exchange(left_, true) ? -1 : robot_;
  }
  if (robot >= 0) hub_.detach(robot, *this);
}

void Session::take_hello(const v1::ClientMessage& message) {
  if (!message.has_hello())
    return end({grpc::StatusCode::FAILED_PRECONDITION, "the first message must be a Hello"});
  const v1::Hello& hello = message.hello();
  if (hello.client().size() > kMaxClientNameBytes)
    return end({grpc::StatusCode::INVALID_ARGUMENT,
                fmt::format("client: found {} bytes, expected at most {}", hello.client().size(),
                            kMaxClientNameBytes)});
  const int number = hub_.robot_number(hello.robot());
  const std::string tried = fmt::format("robot {}", number);
  if (number >= 0) {
    if (const double wait_s = tries_.wait_s(peer_, tried); wait_s > 0) {
      hub_.note_wrong_hello(number);
      return end({grpc::StatusCode::UNAVAILABLE, wait_text(wait_s)});
    }
  }
  const auto attached = hub_.attach(hello.robot(), hello.token(), hello.client(),
                                    std::static_pointer_cast<Session>(shared_from_this()));
  switch (attached.result) {
    case Attachment::unknown_robot:
      return end({grpc::StatusCode::NOT_FOUND,
                  fmt::format("robot: no robot '{}' here", hello.robot().substr(0, 100))});
    case Attachment::wrong_token:
      tries_.note_wrong(peer_, tried);
      hub_.note_wrong_hello(number);
      return end({grpc::StatusCode::UNAUTHENTICATED,
                  fmt::format("token: not the token of robot '{}'", hello.robot())});
    case Attachment::ended:
      return end({grpc::StatusCode::FAILED_PRECONDITION, "the run is over"});
    case Attachment::accepted:
      break;
  }
  const RobotSpec& robot = scenario_.robots[attached.robot];
  v1::ServerMessage reply;
  v1::Welcome& welcome = *reply.mutable_welcome();
  welcome.set_robot(robot.id);
  welcome.set_robot_number(static_cast<uint32_t>(attached.robot));
  welcome.set_decision_latency_ns(robot.behaviour.decision_latency.ns());
  welcome.set_decision_period_ns(robot.behaviour.clock.period.ns());
  welcome.set_image_width_px(static_cast<uint32_t>(robot.camera.width_px));
  welcome.set_image_height_px(static_cast<uint32_t>(robot.camera.height_px));
  welcome.set_team(robot.team == Team::red ? "red" : "blue");
  welcome.set_next_sequence(attached.next_sequence);
  for (size_t j = 0; j < robot.body.joint_count(); ++j)
    welcome.add_joint_names(robot.body.joint_name(j));
  bool left;
  {
    const std::lock_guard lock(mutex_);
    robot_ = attached.robot;
    left = left_;
  }
  if (left) return hub_.detach(attached.robot, *this);  // It broke off meanwhile.
  write(std::move(reply));
  hub_.activate(attached.robot, *this);
}

void Session::take_decision(const v1::ClientMessage& message) {
  if (!message.has_decision()) {
    const std::string found = message.has_hello() ? "a second hello" : "an empty message";
    hub_.note_fault(robot_, "refused", found);
    return refuse(0, {"kind", fmt::format("found {}, expected a decision", found)}, true);
  }
  const v1::Decision& wire = message.decision();
  auto decision = decision_from_wire(wire, scenario_.radio.max_message_bytes);
  if (auto misfit = unfit_for(scenario_.robots[robot_].body, wire)) decision = std::move(*misfit);
  const FieldError* bad = std::get_if<FieldError>(&decision);
  // A refused decision counts as an empty one: the match goes on.
  const Acceptance acceptance = hub_.answer(
      robot_, *this, wire.sequence(), bad ? Decision{} : std::move(std::get<Decision>(decision)));
  const uint64_t sequence = wire.sequence();
  switch (acceptance) {
    case Acceptance::accepted:
      if (!bad) return;
      hub_.note_fault(robot_, "refused", fmt::format("{}: {}", bad->field, bad->message));
      return refuse(sequence, *bad, false);
    case Acceptance::logs_too_much:
      hub_.note_fault(robot_, "refused", "debug: beyond the budget");
      return refuse(sequence,
                    {"debug", fmt::format("found more than the budget, expected at most {} bytes "
                                          "a simulated second",
                                          DebugBudget::kBytesPerSecond)},
                    false);
    case Acceptance::stale:
      hub_.note_fault(robot_, "stale", fmt::format("sequence {}", sequence));
      return refuse(sequence, {"sequence", "of an earlier observation"}, true);
    case Acceptance::duplicate:
      hub_.note_fault(robot_, "duplicate", fmt::format("sequence {}", sequence));
      return refuse(sequence, {"sequence", "this observation was answered already"}, false);
    case Acceptance::future:
      hub_.note_fault(robot_, "future", fmt::format("sequence {}", sequence));
      return refuse(sequence, {"sequence", "of an observation that was not sent yet"}, true);
  }
}

void Session::refuse(uint64_t sequence, const FieldError& error, bool decision_owed) {
  v1::ServerMessage message;
  v1::Refusal& refusal = *message.mutable_refusal();
  refusal.set_sequence(sequence);
  refusal.set_field(error.field);
  refusal.set_message(error.message);
  refusal.set_decision_owed(decision_owed);
  write(std::move(message));
}

class RobotService final : public v1::Simulation::CallbackService {
 public:
  RobotService(const Scenario& scenario, ClientHub& hub, TokenTries& tries)
      : scenario_(scenario), hub_(hub), tries_(tries) {}

  grpc::ServerBidiReactor<v1::ClientMessage, v1::ServerMessage>* Drive(
      grpc::CallbackServerContext* context) override {
    const auto session =
        std::make_shared<Session>(scenario_, hub_, tries_, peer_of(context->peer()));
    session->start();
    return session.get();
  }

 private:
  const Scenario& scenario_;
  ClientHub& hub_;
  TokenTries& tries_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_robot_service(const Scenario& scenario, ClientHub& hub,
                                                  TokenTries& tries) {
  return std::make_unique<RobotService>(scenario, hub, tries);
}

}  // namespace seam::scheduler
