#include "scheduler/wire/wire.h"

#include <cmath>

#include "seam/v1/simulation.pb.h"
#include "seam/v1/turn.pb.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {

namespace {

FieldError error(std::string field, const auto& found, const std::string& expected) {
  return {std::move(field), fmt::format("found {}, expected {}", found, expected)};
}

// The head command is a joint frame of its own at offset 0, so that one path moves all joints.
JointFrame head_frame(const v1::HeadCommand& head) {
  const double speed = head.max_speed_rad_s();
  return {{},
          {{kTilt, head.tilt_rad(), speed},
           {kPan, head.pan_rad(), speed},
           {kRoll, head.roll_rad(), speed}}};
}

std::optional<FieldError> check_head(const v1::HeadCommand& head) {
  const std::pair<const char*, double> angles[] = {{"head.tilt_rad", head.tilt_rad()},
                                                   {"head.pan_rad", head.pan_rad()},
                                                   {"head.roll_rad", head.roll_rad()}};
  constexpr double kAngle = CommandLimits::kMaxAngleRad;
  constexpr double kSpeed = CommandLimits::kMaxSpeedRadps;
  for (const auto& [name, angle] : angles)
    if (!(std::abs(angle) <= kAngle))
      return error(name, angle, fmt::format("a number from {} to {}", -kAngle, kAngle));
  if (!(head.max_speed_rad_s() >= 0 && head.max_speed_rad_s() <= kSpeed))
    return error("head.max_speed_rad_s", head.max_speed_rad_s(),
                 fmt::format("a number from 0 to {}", kSpeed));
  return std::nullopt;
}

std::optional<FieldError> check_walk(const v1::WalkCommand& walk) {
  const std::tuple<const char*, double, double> fields[] = {
      {"walk.vx_m_s", walk.vx_m_s(), CommandLimits::kMaxWalkMps},
      {"walk.vy_m_s", walk.vy_m_s(), CommandLimits::kMaxWalkMps},
      {"walk.omega_rad_s", walk.omega_rad_s(), CommandLimits::kMaxTurnRadps}};
  for (const auto& [name, value, limit] : fields)
    if (!(std::abs(value) <= limit))
      return error(name, value, fmt::format("a number from {} to {}", -limit, limit));
  return std::nullopt;
}

std::optional<FieldError> joints_from(const v1::Decision& wire, size_t joint_count,
                                      RobotCommand& command) {
  if (wire.joints_size() > CommandLimits::kMaxJointFrames)
    return error("joints", wire.joints_size(),
                 fmt::format("at most {} frames", CommandLimits::kMaxJointFrames));
  for (int i = 0; i < wire.joints_size(); ++i) {
    const v1::JointFrame& frame = wire.joints(i);
    if (frame.targets_size() > CommandLimits::kMaxTargetsAFrame)
      return error(fmt::format("joints[{}].targets", i), frame.targets_size(),
                   fmt::format("at most {} targets", CommandLimits::kMaxTargetsAFrame));
    JointFrame joint_frame{SimDuration::from_ns(frame.offset_ns()), {}};
    for (int k = 0; k < frame.targets_size(); ++k) {
      const v1::JointTarget& target = frame.targets(k);
      if (target.joint() >= joint_count)
        return error(fmt::format("joints[{}].targets[{}].joint", i, k), target.joint(),
                     fmt::format("a number below {}", joint_count));
      joint_frame.targets.push_back(
          {static_cast<int>(target.joint()), target.angle_rad(), target.max_speed_rad_s()});
    }
    command.joints.push_back(std::move(joint_frame));
  }
  return std::nullopt;
}

std::optional<FieldError> command_from(const v1::Decision& wire, const RobotBody* body,
                                       RobotCommand& command) {
  const bool is_tree = body != nullptr && body->tree.present();
  if (wire.has_head()) {
    if (is_tree)
      return FieldError{"head", fmt::format("a {} has no head with tilt, pan and roll, expected "
                                            "joints by their numbers",
                                            body->name)};
    if (auto bad = check_head(wire.head())) return bad;
    command.joints.push_back(head_frame(wire.head()));
  }
  if (wire.has_walk()) {
    if (auto bad = check_walk(wire.walk())) return bad;
    command.walk = {wire.walk().vx_m_s(), wire.walk().vy_m_s(), wire.walk().omega_rad_s()};
  }
  const size_t joint_count = body != nullptr ? body->joint_count() : kMostJoints;
  if (auto bad = joints_from(wire, joint_count, command)) return bad;
  if (wire.kick() < 0 || wire.kick() >= kKicks)
    return error("kick", static_cast<int>(wire.kick()),
                 fmt::format("a number from 0 to {}", kKicks - 1));
  if (is_tree && wire.kick() != v1::KICK_NONE)
    return FieldError{"kick", fmt::format("a {} has no kicks", body->name)};
  command.kick = static_cast<Kick>(wire.kick());
  if (auto text = invalid_field(command)) {
    const size_t colon = text->find(": ");
    if (colon == std::string::npos) return FieldError{"joints", *text};
    return FieldError{text->substr(0, colon), text->substr(colon + 2)};
  }
  return std::nullopt;
}

std::optional<FieldError> requests_from(const v1::Decision& wire, Decision& decision) {
  if (wire.frame_requests_size() > WireLimits::kMaxFrameRequests)
    return error("frame_requests", wire.frame_requests_size(),
                 fmt::format("at most {}", WireLimits::kMaxFrameRequests));
  for (int i = 0; i < wire.frame_requests_size(); ++i) {
    const v1::FrameRequest& request = wire.frame_requests(i);
    const std::string name = fmt::format("frame_requests[{}]", i);
    if (request.which() < 0 || request.which() > 2)
      return error(name + ".which", static_cast<int>(request.which()), "0, 1 or 2");
    if (request.count() > WireLimits::kMaxFramesARequest)
      return error(name + ".count", request.count(),
                   fmt::format("at most {}", WireLimits::kMaxFramesARequest));
    constexpr int64_t kDay_ns = 86'400'000'000'000;
    if (request.after_ns() < 0 || request.after_ns() > 365 * kDay_ns)
      return error(name + ".after_ns", request.after_ns(), "a time from 0 to a year");
    decision.frame_requests.push_back({static_cast<FrameRequest::Which>(request.which()),
                                       std::max(request.count(), 1u),
                                       SimTime::from_ns(request.after_ns())});
  }
  return std::nullopt;
}

std::optional<FieldError> debug_from(const v1::Decision& wire, Decision& decision) {
  if (wire.debug_size() > WireLimits::kMaxDebugItems)
    return error("debug", wire.debug_size(), fmt::format("at most {}", WireLimits::kMaxDebugItems));
  for (int i = 0; i < wire.debug_size(); ++i) {
    const v1::DebugItem& item = wire.debug(i);
    const std::string name = fmt::format("debug[{}]", i);
    if (item.name().empty() || item.name().size() > WireLimits::kMaxNameBytes)
      return error(name + ".name", fmt::format("{} bytes", item.name().size()),
                   fmt::format("1 to {} bytes", WireLimits::kMaxNameBytes));
    if (item.text().size() > WireLimits::kMaxTextBytes)
      return error(name + ".text", fmt::format("{} bytes", item.text().size()),
                   fmt::format("at most {} bytes", WireLimits::kMaxTextBytes));
    const int points = item.drawing().points_size();
    if (points % 2 != 0 || points > 2 * WireLimits::kMaxDrawingPoints)
      return error(name + ".drawing.points", points,
                   fmt::format("x, y pairs, at most {}", WireLimits::kMaxDrawingPoints));
    DebugItem out{.name = item.name()};
    if (item.has_value()) {
      out.kind = DebugItem::Kind::value;
      out.value = item.value();
    } else if (item.has_drawing()) {
      out.kind = DebugItem::Kind::drawing;
      out.points.assign(item.drawing().points().begin(), item.drawing().points().end());
      out.in_image = item.drawing().in_image();
      if (item.drawing().has_frame_index()) out.frame_index = item.drawing().frame_index();
    } else {
      out.text = item.text();
    }
    decision.debug.push_back(std::move(out));
  }
  return std::nullopt;
}

void action_to(const SupervisorAction& action, const std::vector<std::string>& robots,
               v1::SupervisorAction& wire) {
  const auto set = [](const Vec3& from, v1::Vector3& to) {
    to.set_x(from.x);
    to.set_y(from.y);
    to.set_z(from.z);
  };
  switch (action.kind) {
    case SupervisorAction::Kind::place_ball:
      set(action.position_m, *wire.mutable_place_ball()->mutable_position_m());
      set(action.velocity_m_s, *wire.mutable_place_ball()->mutable_velocity_m_s());
      break;
    case SupervisorAction::Kind::place_robot:
      wire.mutable_place_robot()->set_robot(robots.at(action.robot));
      wire.mutable_place_robot()->mutable_body()->set_x_m(action.position_m.x);
      wire.mutable_place_robot()->mutable_body()->set_y_m(action.position_m.y);
      wire.mutable_place_robot()->mutable_body()->set_heading_rad(action.heading_rad);
      break;
    case SupervisorAction::Kind::set_game_state:
      wire.set_set_game_state(action.game_state);
      break;
  }
}

}  // namespace

std::variant<Decision, FieldError> decision_from_wire(const v1::Decision& wire,
                                                      int64_t max_radio_bytes,
                                                      const RobotBody* body) {
  Decision decision;
  if (auto bad = command_from(wire, body, decision.command)) return *bad;
  if (auto bad = requests_from(wire, decision)) return *bad;
  if (wire.messages_size() > WireLimits::kMaxRadioMessages)
    return error("messages", wire.messages_size(),
                 fmt::format("at most {}", WireLimits::kMaxRadioMessages));
  for (int i = 0; i < wire.messages_size(); ++i) {
    if (wire.messages(i).size() > static_cast<size_t>(max_radio_bytes))
      return error(fmt::format("messages[{}]", i), fmt::format("{} bytes", wire.messages(i).size()),
                   fmt::format("at most {} bytes", max_radio_bytes));
    decision.messages.push_back(wire.messages(i));
  }
  if (auto bad = debug_from(wire, decision)) return *bad;
  return decision;
}

void decision_to_wire(const Decision& decision, uint64_t sequence, v1::Decision& wire) {
  wire.set_sequence(sequence);
  for (const JointFrame& frame : decision.command.joints) {
    v1::JointFrame& out = *wire.add_joints();
    out.set_offset_ns(frame.offset.ns());
    for (const JointTarget& target : frame.targets) {
      v1::JointTarget& t = *out.add_targets();
      t.set_joint(static_cast<uint32_t>(target.joint));
      t.set_angle_rad(target.angle_rad);
      t.set_max_speed_rad_s(target.speed_radps);
    }
  }
  if (decision.command.walk) {
    wire.mutable_walk()->set_vx_m_s(decision.command.walk->vx_mps);
    wire.mutable_walk()->set_vy_m_s(decision.command.walk->vy_mps);
    wire.mutable_walk()->set_omega_rad_s(decision.command.walk->omega_radps);
  }
  wire.set_kick(static_cast<v1::Kick>(decision.command.kick));
  for (const FrameRequest& request : decision.frame_requests) {
    v1::FrameRequest& out = *wire.add_frame_requests();
    out.set_which(static_cast<v1::FrameRequest::Which>(request.which));
    out.set_count(request.count);
    out.set_after_ns(request.after.ns());
  }
  for (const std::string& message : decision.messages) wire.add_messages(message);
  for (const DebugItem& item : decision.debug) {
    v1::DebugItem& out = *wire.add_debug();
    out.set_name(item.name);
    switch (item.kind) {
      case DebugItem::Kind::value:
        out.set_value(item.value);
        break;
      case DebugItem::Kind::text:
        out.set_text(item.text);
        break;
      case DebugItem::Kind::drawing:
        out.mutable_drawing()->set_in_image(item.in_image);
        if (item.frame_index) out.mutable_drawing()->set_frame_index(*item.frame_index);
        out.mutable_drawing()->mutable_points()->Add(item.points.begin(), item.points.end());
        break;
    }
  }
}

std::variant<SupervisorAction, FieldError> action_from_wire(
    const v1::SupervisorAction& wire, const std::vector<std::string>& robots) {
  SupervisorAction action;
  const auto bad = [](const char* field, double value) {
    return error(field, value, "a finite number from -100 to 100");
  };
  const auto out_of_range = [](double value) { return !(std::abs(value) <= 100); };
  if (wire.has_place_ball()) {
    const v1::Vector3& p = wire.place_ball().position_m();
    const v1::Vector3& v = wire.place_ball().velocity_m_s();
    for (const double value : {p.x(), p.y(), p.z()})
      if (out_of_range(value)) return bad("place_ball.position_m", value);
    for (const double value : {v.x(), v.y(), v.z()})
      if (out_of_range(value)) return bad("place_ball.velocity_m_s", value);
    action.kind = SupervisorAction::Kind::place_ball;
    action.position_m = {p.x(), p.y(), p.z()};
    action.velocity_m_s = {v.x(), v.y(), v.z()};
  } else if (wire.has_place_robot()) {
    const auto found = std::find(robots.begin(), robots.end(), wire.place_robot().robot());
    if (found == robots.end())
      return FieldError{"place_robot.robot",
                        fmt::format("unknown robot '{}'", wire.place_robot().robot())};
    const v1::Pose2& body = wire.place_robot().body();
    for (const double value : {body.x_m(), body.y_m(), body.heading_rad()})
      if (out_of_range(value)) return bad("place_robot.body", value);
    action.kind = SupervisorAction::Kind::place_robot;
    action.robot = static_cast<int>(found - robots.begin());
    action.position_m = {body.x_m(), body.y_m(), 0};
    action.heading_rad = body.heading_rad();
  } else if (wire.kind_case() == v1::SupervisorAction::kSetGameState) {
    if (wire.set_game_state() > 4) return error("set_game_state", wire.set_game_state(), "0 to 4");
    action.kind = SupervisorAction::Kind::set_game_state;
    action.game_state = wire.set_game_state();
  } else {
    return FieldError{"actions", "an action without a kind"};
  }
  return action;
}

void turn_to_wire(SimTime time, const Turn& turn, const std::vector<std::string>& robots,
                  v1::Turn& wire) {
  wire.set_time_ns(time.ns());
  for (const Answer& answer : turn.answers) {
    v1::Answer& out = *wire.add_answers();
    out.set_robot(static_cast<uint32_t>(answer.robot));
    out.set_outcome(static_cast<v1::Answer::Outcome>(answer.outcome));
    out.set_reason(answer.reason);
    decision_to_wire(answer.decision, answer.sequence, *out.mutable_decision());
  }
  for (const SupervisorAction& action : turn.actions)
    action_to(action, robots, *wire.add_actions());
}

std::string encode_turn(SimTime time, const Turn& turn, const std::vector<std::string>& robots) {
  v1::Turn wire;
  turn_to_wire(time, turn, robots, wire);
  return wire.SerializeAsString();
}

SimTime time_from_log(int64_t time_ns, std::string_view field) {
  constexpr int64_t kMost_ns = int64_t{1} << 61;
  if (time_ns < -kMost_ns || time_ns > kMost_ns)
    throw InputError(
        fmt::format("{}: found {}, expected at most {} from 0", field, time_ns, kMost_ns));
  return SimTime::from_ns(time_ns);
}

std::pair<SimTime, Turn> decode_turn(std::string_view bytes,
                                     const std::vector<std::string>& robots) {
  v1::Turn wire;
  if (!wire.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())))
    throw InputError("turn: damaged message");
  return turn_from_wire(wire, robots);
}

std::pair<SimTime, Turn> turn_from_wire(const v1::Turn& wire,
                                        const std::vector<std::string>& robots) {
  Turn turn;
  for (const v1::Answer& answer : wire.answers()) {
    if (answer.robot() >= robots.size())
      throw InputError(
          fmt::format("turn: found robot {}, expected below {}", answer.robot(), robots.size()));
    if (answer.outcome() < 0 || answer.outcome() > 4)
      throw InputError(fmt::format("turn: unknown outcome {}", static_cast<int>(answer.outcome())));
    auto decision = decision_from_wire(answer.decision(), WireLimits::kMaxMessageBytes);
    if (const auto* bad = std::get_if<FieldError>(&decision))
      throw InputError(fmt::format("turn: {}: {}", bad->field, bad->message));
    turn.answers.push_back({static_cast<int>(answer.robot()), answer.decision().sequence(),
                            static_cast<Outcome>(answer.outcome()),
                            std::move(std::get<Decision>(decision)), answer.reason()});
  }
  for (const v1::SupervisorAction& action : wire.actions()) {
    auto converted = action_from_wire(action, robots);
    if (const auto* bad = std::get_if<FieldError>(&converted))
      throw InputError(fmt::format("turn: {}: {}", bad->field, bad->message));
    turn.actions.push_back(std::get<SupervisorAction>(converted));
  }
  return {time_from_log(wire.time_ns(), "turn: time_ns"), std::move(turn)};
}

}  // namespace seam::scheduler
