#include "tools/dm_env_rpc/robot_interface.h"

#include <fmt/format.h>

#include <algorithm>

#include "render/colour/colour_detector.h"
#include "sim_core/body/joint_table.h"
#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

namespace {

// A joint's reading, whatever the robot.
double angle_of(const v1::JointAngles& angles, size_t joint) {
  const auto place = static_cast<int>(joint);
  if (angles.angles_rad_size() > 0)
    return place < angles.angles_rad_size() ? angles.angles_rad(place) : 0;
  if (place == kTilt) return angles.tilt_rad();
  if (place == kPan) return angles.pan_rad();
  if (place == kRoll) return angles.roll_rad();
  const int leg = place - kHeadJoints;
  return leg < angles.legs_rad_size() ? angles.legs_rad(leg) : 0;
}

template <class Values>
void put(const Values& values, google::protobuf::RepeatedField<double>& array) {
  for (const double value : values) array.Add(value);
}

// A number that is there at each turn.
template <class Get>
auto number(Get get) {
  return [get](const Sensed& sensed, rpc::Tensor& tensor) {
    tensor = tensor_of(static_cast<decltype(get(sensed.now))>(get(sensed.now)));
  };
}

// Of the newest frame; before the first all are 0.
auto row_times(int rows,
               const google::protobuf::RepeatedField<int64_t>& (v1::Frame::*times)() const) {
  return [rows, times](const Sensed& sensed, rpc::Tensor& tensor) {
    auto& array = *tensor.mutable_int64s()->mutable_array();
    if (sensed.frame) array = ((*sensed.frame).*times)();
    array.Resize(rows, 0);
    tensor.add_shape(rows);
  };
}

auto pixels(std::vector<int> shape, const std::string& (v1::Frame::*bytes)() const) {
  return [shape, bytes](const Sensed& sensed, rpc::Tensor& tensor) {
    size_t size = 1;
    for (const int dimension : shape) {
      tensor.add_shape(dimension);
      size *= static_cast<size_t>(dimension);
    }
    std::string& array = *tensor.mutable_uint8s()->mutable_array();
    if (sensed.frame) array = ((*sensed.frame).*bytes)();
    array.resize(size);
  };
}

}  // namespace

RobotInterface::RobotInterface(const Scenario& scenario, const RobotSpec& robot)
    : robot_(robot.id), token_(robot.token) {
  add_observation(spec_of("time_ns", rpc::INT64),
                  number([](const v1::Observation& now) { return int64_t{now.time_ns()}; }));
  add_joints(robot.body);
  if (!robot.body.tree.present() || robot.body.moves) add_walk(robot.body.gait);
  add_body_sensors(robot);
  add_camera(robot.camera);
  const auto mates =
      std::count_if(scenario.robots.begin(), scenario.robots.end(),
                    [&](const RobotSpec& other) { return other.team == robot.team; });
  if (mates > 1) add_radio(scenario.radio.max_message_bytes);
  if (scenario.referee.enabled) add_game();
}

void RobotInterface::add_action(rpc::TensorSpec spec, Give give) {
  const uint64_t number = actions_.size() + 1;
  actions_[number] = std::move(give);
  (*specs_.mutable_actions())[number] = std::move(spec);
}

void RobotInterface::add_observation(rpc::TensorSpec spec, Look look, bool of_camera) {
  const uint64_t number = observations_.size() + 1;
  observations_[number] = {std::move(look), of_camera};
  (*specs_.mutable_observations())[number] = std::move(spec);
}

void RobotInterface::add_joints(const RobotBody& body) {
  const std::vector<std::string> names = joint_field_names(body);
  for (size_t joint = 0; joint < names.size(); ++joint) {
    const JointLimits& limits = body.joints[joint];
    constexpr double kMost = CommandLimits::kMaxAngleRad;  // Of a wheel, which has no range.
    add_action(bounded("joints." + names[joint], std::max(limits.min_rad, -kMost),
                       std::min(limits.max_rad, kMost)),
               [joint](const rpc::Tensor& tensor, v1::Decision& decision, v1::WalkCommand&) {
                 if (decision.joints_size() == 0) decision.add_joints();
                 v1::JointTarget& target = *decision.mutable_joints(0)->add_targets();
                 target.set_joint(static_cast<uint32_t>(joint));
                 target.set_angle_rad(tensor.doubles().array(0));
               });
    add_observation(spec_of("joints." + names[joint], rpc::DOUBLE),
                    number([joint](const v1::Observation& now) {
                      return angle_of(now.sensors().joints(), joint);
                    }));
  }
  add_observation(spec_of("joint_log.time_ns", rpc::INT64, {-1}),
                  [](const Sensed& sensed, rpc::Tensor& tensor) {
                    const auto& log = sensed.now.sensors().joint_log();
                    tensor.mutable_int64s();
                    for (const v1::JointAngles& angles : log)
                      tensor.mutable_int64s()->add_array(angles.time_ns());
                    tensor.add_shape(log.size());
                  });
  for (size_t joint = 0; joint < names.size(); ++joint)
    add_observation(spec_of("joint_log." + names[joint], rpc::DOUBLE, {-1}),
                    [joint](const Sensed& sensed, rpc::Tensor& tensor) {
                      const auto& log = sensed.now.sensors().joint_log();
                      tensor.mutable_doubles();
                      for (const v1::JointAngles& angles : log)
                        tensor.mutable_doubles()->add_array(angle_of(angles, joint));
                      tensor.add_shape(log.size());
                    });
}

void RobotInterface::add_walk(const Gait& gait) {
  const auto add = [&](const char* name, double most, void (v1::WalkCommand::*set)(double)) {
    add_action(bounded(std::string("walk.") + name, -most, most),
               [set](const rpc::Tensor& tensor, v1::Decision& decision, v1::WalkCommand& walk) {
                 (walk.*set)(tensor.doubles().array(0));
                 *decision.mutable_walk() = walk;
               });
  };
  add("vx_m_s", gait.max_vx_mps, &v1::WalkCommand::set_vx_m_s);
  add("vy_m_s", gait.max_vy_mps, &v1::WalkCommand::set_vy_m_s);
  add("omega_rad_s", gait.max_omega_radps, &v1::WalkCommand::set_omega_rad_s);
}

void RobotInterface::add_body_sensors(const RobotSpec& robot) {
  const auto add_vector = [&](const char* name, const v1::Vector3& (v1::Sensors::*get)() const) {
    add_observation(
        spec_of(name, rpc::DOUBLE, {3}), [get](const Sensed& sensed, rpc::Tensor& tensor) {
          const v1::Vector3& a = (sensed.now.sensors().*get)();
          put(std::array{a.x(), a.y(), a.z()}, *tensor.mutable_doubles()->mutable_array());
          tensor.add_shape(3);
        });
  };
  add_vector("acceleration_m_s2", &v1::Sensors::acceleration_m_s2);
  if (robot.sensors.gyroscope)
    add_vector("angular_velocity_rad_s", &v1::Sensors::angular_velocity_rad_s);
  add_observation(spec_of("odometry.x_m", rpc::DOUBLE), number([](const v1::Observation& now) {
                    return now.sensors().odometry().x_m();
                  }));
  add_observation(spec_of("odometry.y_m", rpc::DOUBLE), number([](const v1::Observation& now) {
                    return now.sensors().odometry().y_m();
                  }));
  add_observation(
      spec_of("odometry.heading_rad", rpc::DOUBLE),
      number([](const v1::Observation& now) { return now.sensors().odometry().heading_rad(); }));
  if (robot.body.tree.present()) return;
  add_observation(spec_of("paw_contact", rpc::BOOL, {kLegs}),
                  [](const Sensed& sensed, rpc::Tensor& tensor) {
                    auto& array = *tensor.mutable_bools()->mutable_array();
                    array = sensed.now.sensors().paw_contact();
                    array.Resize(kLegs, false);
                    tensor.add_shape(kLegs);
                  });
  rpc::TensorSpec kick = spec_of("kick", rpc::INT32);
  kick.mutable_min()->mutable_int32s()->add_array(v1::Kick_MIN);
  kick.mutable_max()->mutable_int32s()->add_array(v1::Kick_MAX);
  add_action(kick, [](const rpc::Tensor& tensor, v1::Decision& decision, v1::WalkCommand&) {
    decision.set_kick(static_cast<v1::Kick>(tensor.int32s().array(0)));
  });
}

void RobotInterface::add_camera(const CameraSpec& camera) {
  const int width = static_cast<int>(camera.width_px), height = static_cast<int>(camera.height_px);
  const auto of_frame = [](int64_t (*get)(const v1::Frame&), int64_t before_the_first) {
    return [get, before_the_first](const Sensed& sensed, rpc::Tensor& tensor) {
      tensor = tensor_of(sensed.frame ? get(*sensed.frame) : before_the_first);
    };
  };
  add_observation(
      spec_of("camera.frame_index", rpc::INT64),
      of_frame([](const v1::Frame& frame) { return static_cast<int64_t>(frame.index()); }, -1),
      true);
  add_observation(spec_of("camera.stamp_ns", rpc::INT64),
                  of_frame([](const v1::Frame& frame) { return int64_t{frame.stamp_ns()}; }, 0),
                  true);
  add_observation(spec_of("camera.rgb", rpc::UINT8, {height, width, 3}),
                  pixels({height, width, 3}, &v1::Frame::rgb), true);
  if (!camera.colour_table_yaml.empty()) {
    const render::Detections size = render::no_detections(width, height);
    add_observation(spec_of("camera.colours", rpc::UINT8, {size.height_px, size.width_px}),
                    pixels({size.height_px, size.width_px}, &v1::Frame::colours), true);
  }
  add_observation(spec_of("camera.row_start_ns", rpc::INT64, {height}),
                  row_times(height, &v1::Frame::row_start_ns), true);
  add_observation(spec_of("camera.row_end_ns", rpc::INT64, {height}),
                  row_times(height, &v1::Frame::row_end_ns), true);
}

void RobotInterface::add_radio(int64_t most_bytes) {
  add_action(spec_of("radio", rpc::UINT8, {-1}),
             [most_bytes](const rpc::Tensor& tensor, v1::Decision& decision, v1::WalkCommand&) {
               const std::string& bytes = tensor.uint8s().array();
               if (bytes.size() > static_cast<size_t>(most_bytes))
                 throw RequestError(grpc::StatusCode::OUT_OF_RANGE,
                                    fmt::format("action 'radio': found {} bytes, expected at most "
                                                "{}",
                                                bytes.size(), most_bytes));
               decision.add_messages(bytes);
             });
  add_observation(spec_of("radio.from", rpc::STRING, {-1}),
                  [](const Sensed& sensed, rpc::Tensor& tensor) {
                    tensor.mutable_strings();
                    for (const v1::RadioMessage& message : sensed.now.messages())
                      tensor.mutable_strings()->add_array(message.from());
                    tensor.add_shape(sensed.now.messages_size());
                  });
  // Messages differ in length: their bytes one after the other, and how many each has.
  add_observation(spec_of("radio.bytes", rpc::UINT8, {-1}),
                  [](const Sensed& sensed, rpc::Tensor& tensor) {
                    std::string& all = *tensor.mutable_uint8s()->mutable_array();
                    for (const v1::RadioMessage& message : sensed.now.messages())
                      all += message.payload();
                    tensor.add_shape(static_cast<int>(all.size()));
                  });
  add_observation(
      spec_of("radio.lengths", rpc::INT64, {-1}), [](const Sensed& sensed, rpc::Tensor& tensor) {
        tensor.mutable_int64s();
        for (const v1::RadioMessage& message : sensed.now.messages())
          tensor.mutable_int64s()->add_array(static_cast<int64_t>(message.payload().size()));
        tensor.add_shape(sensed.now.messages_size());
      });
}

void RobotInterface::add_game() {
  const auto add = [&](const char* name, auto get) {
    add_observation(spec_of(std::string("game.") + name, rpc::INT64),
                    number([get](const v1::Observation& now) {
                      return static_cast<int64_t>(get(now.game()));
                    }));
  };
  add("state", [](const v1::GameState& game) { return game.state(); });
  add("own_score", [](const v1::GameState& game) { return game.own_score(); });
  add("opponent_score", [](const v1::GameState& game) { return game.opponent_score(); });
  add("remaining_ns", [](const v1::GameState& game) { return game.remaining_ns(); });
  add("penalty", [](const v1::GameState& game) { return game.penalty(); });
}

v1::Decision RobotInterface::decide(const google::protobuf::Map<uint64_t, rpc::Tensor>& actions,
                                    v1::WalkCommand& walk) const {
  v1::Decision decision;
  v1::WalkCommand new_walk = walk;
  // In the order of their numbers: a map on the wire has none.
  for (const auto& [number, tensor] : std::map<uint64_t, const rpc::Tensor*>([&] {
         std::map<uint64_t, const rpc::Tensor*> ordered;
         for (const auto& [uid, value] : actions) ordered[uid] = &value;
         return ordered;
       }())) {
    const auto known = actions_.find(number);
    if (known == actions_.end())
      throw RequestError(grpc::StatusCode::NOT_FOUND,
                         fmt::format("action {}: no action of robot '{}', expected 1 to {}", number,
                                     robot_, actions_.size()));
    const rpc::TensorSpec& spec = specs_.actions().at(number);
    check_tensor(*tensor, spec, fmt::format("action '{}'", spec.name()));
    known->second(*tensor, decision, new_walk);
  }
  walk = new_walk;
  return decision;
}

void RobotInterface::check_observations(const Numbers& asked) const {
  for (const uint64_t number : asked)
    if (!observations_.contains(number))
      throw RequestError(
          grpc::StatusCode::NOT_FOUND,
          fmt::format("observation {}: no observation of robot '{}', expected 1 to {}", number,
                      robot_, observations_.size()));
}

bool RobotInterface::asks_for_frames(const Numbers& asked) const {
  return std::any_of(asked.begin(), asked.end(),
                     [&](uint64_t number) { return observations_.at(number).of_camera; });
}

void RobotInterface::observe(const Sensed& sensed, const Numbers& asked,
                             google::protobuf::Map<uint64_t, rpc::Tensor>& observations) const {
  for (const uint64_t number : asked)
    if (!observations.contains(number)) observations_.at(number).look(sensed, observations[number]);
}

}  // namespace seam::tools::dm
