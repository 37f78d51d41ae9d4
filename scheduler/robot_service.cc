// The robots' streams: one session a stream. A session turns wire messages into calls of the hub;
// nothing that a client sends goes anywhere else.
#include <fmt/format.h>
#include <grpcpp/alarm.h>
#include <grpcpp/grpcpp.h>

#include <deque>
#include <mutex>

#include "scheduler/clock.h"
#include "scheduler/services.h"
#include "scheduler/wire.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace seam::scheduler {

namespace {

constexpr int kHelloSeconds = 10;
// Messages that wait to be written; a client that sends but never reads is not read from further.
constexpr size_t kMaxUnwritten = 16;
constexpr size_t kMaxClientNameBytes = 200;

class Session final : public grpc::ServerBidiReactor<v1::ClientMessage, v1::ServerMessage>,
                      public ClientConnection,
                      public std::enable_shared_from_this<Session> {
 public:
  Session(const Scenario& scenario, ClientHub& hub) : scenario_(scenario), hub_(hub) {}

  // The stream keeps itself alive until gRPC is done with it.
  void start() {
    self_ = shared_from_this();
    hello_alarm_.Set(std::chrono::system_clock::now() + std::chrono::seconds(kHelloSeconds),
                     [weak = weak_from_this()](bool expired) {
                       const auto session = weak.lock();
                       if (expired && session) session->hello_is_late();
                     });
    StartRead(&incoming_);
  }

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

  // ---- Reactor ----
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override { leave(); }
  void OnDone() override {
    leave();
    hello_alarm_.Cancel();
    self_.reset();
  }

 private:
  void take_hello(const v1::ClientMessage& message);
  void take_decision(const v1::ClientMessage& message);
  void refuse(uint64_t sequence, const FieldError& error, bool decision_owed);
  void hello_is_late();
  void leave();
  void write(v1::ServerMessage message);
  void end(const grpc::Status& status);
  void read_on();

  const Scenario& scenario_;
  ClientHub& hub_;
  std::shared_ptr<Session> self_;
  grpc::Alarm hello_alarm_;
  v1::ClientMessage incoming_;  // Of the one read under way.

  std::mutex mutex_;
  int robot_ = -1;  // Once the hello was accepted.
  bool left_ = false;
  std::deque<v1::ServerMessage> unwritten_;  // The first is being written.
  bool reading_held_ = false;
  std::optional<grpc::Status> status_;  // Given to Finish when all is written.
  bool finished_ = false;
};

void Session::write(v1::ServerMessage message) {
  const std::lock_guard lock(mutex_);
  if (status_) return;
  unwritten_.push_back(std::move(message));
  if (unwritten_.size() == 1) StartWrite(&unwritten_.front());
}

void Session::end(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  if (status_) return;
  status_ = status;
  if (unwritten_.empty() && !std::exchange(finished_, true)) Finish(*status_);
}

void Session::OnWriteDone(bool ok) {
  bool resume_reading = false;
  {
    const std::lock_guard lock(mutex_);
    unwritten_.pop_front();
    if (!ok) unwritten_.clear();
    if (!unwritten_.empty()) {
      StartWrite(&unwritten_.front());
    } else if (status_) {
      if (!std::exchange(finished_, true)) Finish(*status_);
    }
    if (unwritten_.size() < kMaxUnwritten) resume_reading = std::exchange(reading_held_, false);
  }
  if (resume_reading) StartRead(&incoming_);
}

void Session::read_on() {
  {
    const std::lock_guard lock(mutex_);
    if (unwritten_.size() >= kMaxUnwritten) {
      reading_held_ = true;
      return;
    }
  }
  StartRead(&incoming_);
}

void Session::leave() {
  int robot;
  {
    const std::lock_guard lock(mutex_);
    robot = std::exchange(left_, true) ? -1 : robot_;
  }
  if (robot < 0) return;
  hub_.detach(robot, *this);
}

void Session::hello_is_late() {
  {
    const std::lock_guard lock(mutex_);
    if (robot_ >= 0) return;
  }
  end({grpc::StatusCode::DEADLINE_EXCEEDED, fmt::format("no hello within {} s", kHelloSeconds)});
}

void Session::OnReadDone(bool ok) {
  if (!ok) {
    leave();
    end(grpc::Status::OK);
    return;
  }
  int robot;
  {
    const std::lock_guard lock(mutex_);
    robot = robot_;
  }
  if (robot < 0)
    take_hello(incoming_);
  else
    take_decision(incoming_);
  read_on();
}

void Session::take_hello(const v1::ClientMessage& message) {
  if (!message.has_hello())
    return end({grpc::StatusCode::FAILED_PRECONDITION, "the first message must be a Hello"});
  const v1::Hello& hello = message.hello();
  if (hello.client().size() > kMaxClientNameBytes)
    return end({grpc::StatusCode::INVALID_ARGUMENT,
                fmt::format("client: found {} bytes, expected at most {}", hello.client().size(),
                            kMaxClientNameBytes)});
  const auto attached = hub_.attach(hello.robot(), hello.token(), shared_from_this());
  switch (attached.result) {
    case Attachment::unknown_robot:
      return end({grpc::StatusCode::NOT_FOUND, fmt::format("robot: no robot '{}' here",
                                                           hello.robot().substr(0, 100))});
    case Attachment::wrong_token:
      hub_.note_fault(hub_.robot_number(hello.robot()), "wrong_token", "a client was refused");
      return end({grpc::StatusCode::UNAUTHENTICATED,
                  fmt::format("token: not the token of robot '{}'", hello.robot())});
    case Attachment::ended:
      return end({grpc::StatusCode::FAILED_PRECONDITION, "the run is over"});
    case Attachment::accepted: break;
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
  const FieldError* bad = std::get_if<FieldError>(&decision);
  // A refused decision counts as an empty one: the match goes on.
  const Acceptance acceptance =
      hub_.answer(robot_, *this, wire.sequence(), bad ? Decision{} : std::move(std::get<Decision>(decision)));
  const uint64_t sequence = wire.sequence();
  switch (acceptance) {
    case Acceptance::accepted:
      if (!bad) return;
      hub_.note_fault(robot_, "refused", fmt::format("{}: {}", bad->field, bad->message));
      return refuse(sequence, *bad, false);
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
  RobotService(const Scenario& scenario, ClientHub& hub) : scenario_(scenario), hub_(hub) {}

  grpc::ServerBidiReactor<v1::ClientMessage, v1::ServerMessage>* Drive(
      grpc::CallbackServerContext*) override {
    const auto session = std::make_shared<Session>(scenario_, hub_);
    session->start();
    return session.get();
  }

 private:
  const Scenario& scenario_;
  ClientHub& hub_;
};

}  // namespace

std::unique_ptr<grpc::Service> make_robot_service(const Scenario& scenario, ClientHub& hub) {
  return std::make_unique<RobotService>(scenario, hub);
}

}  // namespace seam::scheduler
