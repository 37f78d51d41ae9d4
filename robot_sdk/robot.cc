#include "robot_sdk/robot.h"

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <stdexcept>
#include <thread>

#include "proto/client_channel.h"
#include "proto/line_stream.h"
#include "robot_sdk/from_wire.h"
#include "robot_sdk/standby.h"
#include "seam/v1/simulation.grpc.pb.h"

namespace seam::sdk {

struct Robot::Implementation {
  Connection connection;
  std::function<void(const Observation&)> handler = [](const Observation&) {};
  // A mistake is mostly made at each turn: the first of each field is printed.
  std::function<void(const Refusal&)> refusal_handler = [this](const Refusal& refusal) {
    if (!refused_fields.insert(refusal.field).second) return;
    std::fprintf(
        stderr,
        "%s: the decision at %.3f s was refused: %s: %s (more of this field are counted by "
        "the server alone)\n",
        connection.robot.c_str(), time_s, refusal.field.c_str(), refusal.message.c_str());
  };
  std::set<std::string> refused_fields;
  double time_s = 0;  // Of the newest observation.
  v1::Welcome welcome;
  std::vector<std::string> joint_names;
  v1::ClientMessage answer;  // Gathers the handler's orders.
  uint64_t answered = 0;     // The last observation that the handler has seen.
  bool over = false;
  bool was_connected = false;

  v1::Decision& decision() { return *answer.mutable_decision(); }
  // Over a stream of gRPC or a direct line, until it ends.
  template <class Stream>
  grpc::Status drive(Stream& stream);
  template <class Stream>
  bool take(const v1::ServerMessage& message, Stream& stream);
};

template <class Stream>
bool Robot::Implementation::take(const v1::ServerMessage& message, Stream& stream) {
  switch (message.kind_case()) {
    case v1::ServerMessage::kWelcome:
      welcome = message.welcome();
      joint_names.assign(welcome.joint_names().begin(), welcome.joint_names().end());
      was_connected = true;
      return true;
    case v1::ServerMessage::kObservation: {
      const Observation observation = from_wire(message.observation());
      // After a reconnection the pending observation comes again. Where the answer was made but
      // lost on the way, it is sent again, not made twice.
      if (observation.sequence != answered) {
        if (answered > 0) answer.Clear();
        answered = observation.sequence;
        time_s = observation.time_s();
        handler(observation);
        decision().set_sequence(observation.sequence);
      }
      return stream.Write(answer);
    }
    case v1::ServerMessage::kRefusal:
      refusal_handler({message.refusal().field(), message.refusal().message()});
      return true;
    case v1::ServerMessage::kGoodbye:
      over = true;
      return false;
    case v1::ServerMessage::kWatched:  // Of a script with the supervisor's rights, never here.
    case v1::ServerMessage::KIND_NOT_SET:
      return true;
  }
  return true;
}

template <class Stream>
grpc::Status Robot::Implementation::drive(Stream& stream) {
  v1::ClientMessage first;
  first.mutable_hello()->set_robot(connection.robot);
  first.mutable_hello()->set_token(connection.token);
  first.mutable_hello()->set_client("seam C++ SDK 1");
  v1::ServerMessage message;
  if (stream.Write(first))
    while (stream.Read(&message))
      if (!take(message, stream)) break;
  if (over) stream.WritesDone();
  return stream.Finish();
}

Connection Connection::from(int argc, char** argv) {
  stand_by();
  // `seam run` reads what is printed through a pipe, and gives each line the time at which it came.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  const auto value = [&](const std::string& option, const char* variable) -> std::string {
    for (int i = 1; i + 1 < argc; ++i)
      if (option == argv[i]) return argv[i + 1];
    const char* text = std::getenv(variable);
    return text == nullptr ? "" : text;
  };
  Connection found{value("--address", "SEAM_ADDRESS"), value("--robot", "SEAM_ROBOT"),
                   value("--token", "SEAM_TOKEN"), value("--certs", "SEAM_CERTS")};
  if (value("--address", "").empty()) found.line = value("", "SEAM_LINE");
  return found;
}

Robot::Robot(Connection connection) : implementation_(std::make_unique<Implementation>()) {
  implementation_->connection = std::move(connection);
}

Robot::~Robot() = default;

const std::string& Robot::name() const {
  return implementation_->connection.robot;
}
const std::string& Robot::team() const {
  return implementation_->welcome.team();
}
int Robot::number() const {
  return static_cast<int>(implementation_->welcome.robot_number());
}
double Robot::decision_latency_s() const {
  return static_cast<double>(implementation_->welcome.decision_latency_ns()) * 1e-9;
}

const std::vector<std::string>& Robot::joint_names() const {
  return implementation_->joint_names;
}
int Robot::joint(std::string_view name) const {
  std::string known;
  for (size_t i = 0; i < joint_names().size(); ++i) {
    if (joint_names()[i] == name) return static_cast<int>(i);
    known += " " + joint_names()[i];
  }
  throw std::invalid_argument("no joint '" + std::string(name) + "', expected one of:" + known);
}

void Robot::on_observation(std::function<void(const Observation&)> handler) {
  implementation_->handler = std::move(handler);
}

void Robot::on_refusal(std::function<void(const Refusal&)> handler) {
  implementation_->refusal_handler = std::move(handler);
}

int Robot::run() {
  Implementation& self = *implementation_;
  if (self.connection.address.empty()) {
    std::fprintf(stderr, "no server address: give --address, or set SEAM_ADDRESS\n");
    return 1;
  }
  try {
    std::unique_ptr<v1::Simulation::Stub> stub;
    const auto connect = [&] {
      if (!self.connection.line.empty()) {
        LineStream line(self.connection.line);
        return self.drive(line);
      }
      if (!stub)
        stub = v1::Simulation::NewStub(
            open_channel(self.connection.address, self.connection.certificates));
      grpc::ClientContext context;
      context.set_wait_for_ready(false);
      return self.drive(*stub->Drive(&context));
    };
    auto last_connected = std::chrono::steady_clock::now();
    while (true) {
      self.was_connected = false;
      const grpc::Status status = connect();
      if (self.over) return 0;
      const auto now = std::chrono::steady_clock::now();
      if (self.was_connected) last_connected = now;
      const std::chrono::duration<double> without = now - last_connected;
      if (!passes(status.error_code()) || without.count() > self.connection.give_up_s) {
        std::fprintf(stderr, "%s: %s\n", self.connection.robot.c_str(),
                     status.error_message().c_str());
        return 1;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", self.connection.robot.c_str(), error.what());
    return 1;
  }
}

void Robot::head(const Head& target) {
  v1::HeadCommand& head = *implementation_->decision().mutable_head();
  head.set_tilt_rad(target.tilt_rad);
  head.set_pan_rad(target.pan_rad);
  head.set_roll_rad(target.roll_rad);
  head.set_max_speed_rad_s(target.max_speed_rad_s);
}

void Robot::walk(const Walk& velocity) {
  v1::WalkCommand& walk = *implementation_->decision().mutable_walk();
  walk.set_vx_m_s(velocity.vx_m_s);
  walk.set_vy_m_s(velocity.vy_m_s);
  walk.set_omega_rad_s(velocity.omega_rad_s);
}

void Robot::kick(Kick kind) {
  implementation_->decision().set_kick(static_cast<v1::Kick>(kind));
}

void Robot::joints(const std::vector<JointTarget>& targets, int64_t offset_ns) {
  v1::JointFrame& frame = *implementation_->decision().add_joints();
  frame.set_offset_ns(offset_ns);
  for (const JointTarget& target : targets) {
    v1::JointTarget& wire = *frame.add_targets();
    wire.set_joint(static_cast<uint32_t>(target.joint));
    wire.set_angle_rad(target.angle_rad);
    wire.set_max_speed_rad_s(target.max_speed_rad_s);
  }
}

void Robot::request_frame(int64_t after_ns) {
  v1::FrameRequest& request = *implementation_->decision().add_frame_requests();
  request.set_which(v1::FrameRequest::NEXT);
  request.set_after_ns(after_ns);
}

void Robot::request_frames(int count) {
  v1::FrameRequest& request = *implementation_->decision().add_frame_requests();
  request.set_which(v1::FrameRequest::NEXT);
  request.set_count(static_cast<uint32_t>(count));
}

void Robot::request_all_frames() {
  implementation_->decision().add_frame_requests()->set_which(v1::FrameRequest::ALL);
}

void Robot::request_no_frames() {
  implementation_->decision().add_frame_requests()->set_which(v1::FrameRequest::NONE);
}

void Robot::send(std::string_view payload) {
  implementation_->decision().add_messages(payload.data(), payload.size());
}

void Robot::log_value(std::string_view name, double value) {
  v1::DebugItem& item = *implementation_->decision().add_debug();
  item.set_name(name.data(), name.size());
  item.set_value(value);
}

void Robot::log_text(std::string_view name, std::string_view text) {
  v1::DebugItem& item = *implementation_->decision().add_debug();
  item.set_name(name.data(), name.size());
  item.set_text(text.data(), text.size());
}

void Robot::log_drawing(std::string_view name, const std::vector<double>& xy, bool in_image,
                        std::optional<uint64_t> frame_index) {
  v1::DebugItem& item = *implementation_->decision().add_debug();
  item.set_name(name.data(), name.size());
  item.mutable_drawing()->set_in_image(in_image);
  if (frame_index) item.mutable_drawing()->set_frame_index(*frame_index);
  item.mutable_drawing()->mutable_points()->Add(xy.begin(), xy.end());
}

}  // namespace seam::sdk
