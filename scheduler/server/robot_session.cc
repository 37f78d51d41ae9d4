#include "scheduler/server/robot_session.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "scheduler/loop/clock.h"
#include "scheduler/loop/command_notes.h"
#include "scheduler/wire/token.h"
#include "scheduler/wire/wire.h"
#include "sim_core/base/error.h"
#include "sim_core/body/joint_table.h"

namespace seam::scheduler {

namespace {

constexpr size_t kMaxClientNameBytes = 200;
constexpr int kMaxWatched = 64;

// What is to be said of targets beyond their joints' ranges, by joint.
std::map<size_t, std::string> clamped_by(const RobotBody& body, const RobotCommand& command) {
  std::map<size_t, std::string> notes;
  for (const JointFrame& frame : command.joints) {
    for (const JointTarget& target : frame.targets) {
      const auto joint = static_cast<size_t>(target.joint);
      if (joint >= body.joint_count()) continue;
      if (auto text = out_of_range_text(body, joint, target.angle_rad)) notes.emplace(joint, *text);
    }
  }
  return notes;
}

}  // namespace

void RobotSession::send(std::shared_ptr<const Observation> observation,
                        const std::vector<int>& asked) {
  {
    const std::lock_guard lock(mutex_);
    sent_ = observation->sequence;
  }
  tell_watched(observation->time, asked);
  v1::ServerMessage message;
  observation_to_wire(*observation, *message.mutable_observation());
  say(std::move(message));
}

void RobotSession::tell_watched(SimTime time, const std::vector<int>& asked) {
  if (!watch_) return;
  v1::ServerMessage message;
  v1::Watched& watched = *message.mutable_watched();
  watched.set_time_ns(time.ns());
  for (const double value : watch_->values(time)) watched.add_values(value);
  for (const int robot : asked)
    watched.add_robots(parts_.scenario.robots[static_cast<size_t>(robot)].id);
  say(std::move(message));
}

void RobotSession::say_goodbye(SimTime time, const std::string& reason) {
  tell_watched(time, {});
  v1::ServerMessage message;
  message.mutable_goodbye()->set_reason(reason);
  message.mutable_goodbye()->set_time_ns(time.ns());
  say(std::move(message));
  hang_up(grpc::Status::OK);
}

void RobotSession::drop(const std::string& reason) {
  hang_up({grpc::StatusCode::ABORTED, reason});
}

void RobotSession::take_message(const v1::ClientMessage& message) {
  if (has_greeted())
    take_decision(message);
  else
    take_hello(message);
}

void RobotSession::client_left() {
  int robot;
  {
    const std::lock_guard lock(mutex_);
    robot = std::exchange(left_, true) ? -1 : robot_;
  }
  if (robot >= 0) parts_.hub.detach(robot, *this);
}

bool RobotSession::has_greeted() {
  const std::lock_guard lock(mutex_);
  return robot_ >= 0;
}

bool RobotSession::take_watch(const v1::Hello& hello) {
  if (!hello.has_watch()) return true;
  const auto refuse = [this](grpc::StatusCode code, const std::string& text) {
    hang_up({code, text});
    return false;
  };
  constexpr const char* kTried = "supervisor";
  if (const double wait_s = parts_.tries.wait_s(peer_, kTried); wait_s > 0)
    return refuse(grpc::StatusCode::UNAVAILABLE, wait_text(wait_s));
  const v1::Watch& watch = hello.watch();
  if (parts_.supervisor_token.empty() || !same_token(watch.token(), parts_.supervisor_token)) {
    parts_.tries.note_wrong(peer_, kTried);
    return refuse(grpc::StatusCode::UNAUTHENTICATED, "watch.token: not the supervisor's token");
  }
  if (watch.expressions_size() > kMaxWatched)
    return refuse(grpc::StatusCode::INVALID_ARGUMENT,
                  fmt::format("watch.expressions: found {}, expected at most {}",
                              watch.expressions_size(), kMaxWatched));
  if (parts_.watches == nullptr)
    return refuse(grpc::StatusCode::FAILED_PRECONDITION, "watch: nothing can be watched here");
  try {
    watch_ = parts_.watches->watch(hello.robot(),
                                   {watch.expressions().begin(), watch.expressions().end()});
  } catch (const UsageError& error) {
    return refuse(grpc::StatusCode::INVALID_ARGUMENT, error.what());
  }
  return true;
}

void RobotSession::take_hello(const v1::ClientMessage& message) {
  if (!message.has_hello())
    return hang_up({grpc::StatusCode::FAILED_PRECONDITION, "the first message must be a Hello"});
  const v1::Hello& hello = message.hello();
  if (hello.client().size() > kMaxClientNameBytes)
    return hang_up({grpc::StatusCode::INVALID_ARGUMENT,
                    fmt::format("client: found {} bytes, expected at most {}",
                                hello.client().size(), kMaxClientNameBytes)});
  const int number = parts_.hub.robot_number(hello.robot());
  const std::string tried = fmt::format("robot {}", number);
  if (number >= 0) {
    if (const double wait_s = parts_.tries.wait_s(peer_, tried); wait_s > 0) {
      parts_.hub.note_wrong_hello(number);
      return hang_up({grpc::StatusCode::UNAVAILABLE, wait_text(wait_s)});
    }
  }
  if (!take_watch(hello)) return;
  const auto attached = parts_.hub.attach(hello.robot(), hello.token(), hello.client(), self());
  switch (attached.result) {
    case Attachment::unknown_robot:
      return hang_up({grpc::StatusCode::NOT_FOUND,
                      fmt::format("robot: no robot '{}' here", hello.robot().substr(0, 100))});
    case Attachment::wrong_token:
      parts_.tries.note_wrong(peer_, tried);
      parts_.hub.note_wrong_hello(number);
      return hang_up({grpc::StatusCode::UNAUTHENTICATED,
                      fmt::format("token: not the token of robot '{}'", hello.robot())});
    case Attachment::ended:
      return hang_up({grpc::StatusCode::FAILED_PRECONDITION, "the run is over"});
    case Attachment::accepted:
      break;
  }
  const RobotSpec& robot = parts_.scenario.robots[attached.robot];
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
  if (left) return parts_.hub.detach(attached.robot, *this);  // It broke off meanwhile.
  say(std::move(reply));
  parts_.hub.activate(attached.robot, *this);
}

void RobotSession::take_decision(const v1::ClientMessage& message) {
  if (!message.has_decision()) {
    const std::string found = message.has_hello() ? "a second hello" : "an empty message";
    parts_.hub.note_fault(robot_, kRefusedFault, found);
    return refuse(0, {"kind", fmt::format("found {}, expected a decision", found)}, true);
  }
  const v1::Decision& wire = message.decision();
  const RobotBody& body = parts_.scenario.robots[robot_].body;
  auto decision = decision_from_wire(wire, parts_.scenario.radio.max_message_bytes, &body);
  const FieldError* bad = std::get_if<FieldError>(&decision);
  DecisionDoubts doubts;
  if (bad != nullptr)
    doubts.refused = fmt::format("{}: {}", bad->field, bad->message);
  else
    doubts.clamped = clamped_by(body, std::get<Decision>(decision).command);
  // A refused decision counts as an empty one: the match goes on.
  answer(wire.sequence(), bad ? Decision{} : std::move(std::get<Decision>(decision)), bad, doubts);
}

void RobotSession::take_too_long(size_t bytes) {
  if (!has_greeted())
    return hang_up({grpc::StatusCode::RESOURCE_EXHAUSTED,
                    fmt::format("found a message of {} bytes, expected at most {}", bytes,
                                WireLimits::kMaxMessageBytes)});
  uint64_t sequence;
  {
    const std::lock_guard lock(mutex_);
    sequence = sent_;
  }
  const FieldError bad{"decision", fmt::format("found {} bytes, expected at most {} with all that "
                                               "is logged and sent",
                                               bytes, WireLimits::kMaxMessageBytes)};
  answer(sequence, {}, &bad, {.refused = bad.field + ": " + bad.message});
}

void RobotSession::answer(uint64_t sequence, Decision decision, const FieldError* bad,
                          const DecisionDoubts& doubts) {
  const Acceptance acceptance =
      parts_.hub.answer(robot_, *this, sequence, std::move(decision), doubts);
  switch (acceptance) {
    case Acceptance::accepted:
      if (!bad) return;
      return refuse(sequence, *bad, false);
    case Acceptance::logs_too_much:
      return refuse(sequence,
                    {"debug", fmt::format("found more than the budget, expected at most {} bytes "
                                          "a simulated second",
                                          DebugBudget::kBytesPerSecond)},
                    false);
    case Acceptance::stale:
      parts_.hub.note_fault(robot_, "stale", fmt::format("sequence {}", sequence));
      return refuse(sequence, {"sequence", "of an earlier observation"}, true);
    case Acceptance::duplicate:
      parts_.hub.note_fault(robot_, "duplicate", fmt::format("sequence {}", sequence));
      return refuse(sequence, {"sequence", "this observation was answered already"}, false);
    case Acceptance::future:
      parts_.hub.note_fault(robot_, "future", fmt::format("sequence {}", sequence));
      return refuse(sequence, {"sequence", "of an observation that was not sent yet"}, true);
  }
}

void RobotSession::refuse(uint64_t sequence, const FieldError& error, bool decision_owed) {
  v1::ServerMessage message;
  v1::Refusal& refusal = *message.mutable_refusal();
  refusal.set_sequence(sequence);
  refusal.set_field(error.field);
  refusal.set_message(error.message);
  refusal.set_decision_owed(decision_owed);
  say(std::move(message));
}

}  // namespace seam::scheduler
