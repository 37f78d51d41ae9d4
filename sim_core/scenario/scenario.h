// A scenario: who plays where with what, read from a file of format seam-scenario/1
// (docs/reference/scenario.md). Plain values; whatever stands here has passed all checks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim_core/base/random.h"
#include "sim_core/base/time.h"
#include "sim_core/body/robot_body.h"
#include "sim_core/scenario/object_spec.h"
#include "sim_core/scene/field.h"

namespace seam {

enum class Team : uint8_t { red, blue };

struct Pose2 {
  double x_m = 0;
  double y_m = 0;
  double theta_rad = 0;
  bool operator==(const Pose2&) const = default;
};

// Tick i is at phase + i * period * (1 + drift_ppm * 1e-6) + jitter(i).
struct ClockSpec {
  SimDuration period = SimDuration::from_ns(40'000'000);
  SimDuration phase;
  double drift_ppm = 0;
  SimDuration jitter_sigma;  // Seeded; tick times stay in order.
};

struct CameraSpec {
  std::string model_yaml;  // A seam-model/1 file's text: effects of camera, joints and locomotion.
  std::string model_name;  // Where it came from, for messages. Empty: no model was given.
  std::string colour_table_yaml;  // A seam-colour-table/1 file's text. Empty: no colour layer.
  std::string colour_table_name;
  int64_t width_px = 178;
  int64_t height_px = 144;
  ClockSpec clock;
  // Locked to the head's swing: tick i is at lock_start + i * lock_cycle / lock_frames.
  bool locked = false;
  SimDuration lock_cycle = SimDuration::from_ns(1'000'000'000);
  SimDuration lock_start;
  int64_t lock_frames = 25;
  int64_t instants_per_row = 8;  // At least this many light samples fall into each row's window.
  bool every_frame = false;      // Deliver each frame without being asked.
};

// What happens to a robot whose behaviour owes a decision and stays silent.
enum class SilencePolicy : uint8_t { wait, freeze, abort };

struct BehaviourSpec {
  std::vector<std::string>
      command;  // argv; argv[0] is a name in <build>/behaviours/. Empty: none is started.
  ClockSpec clock = {.period = SimDuration::from_ns(32'000'000)};
  SimDuration decision_latency;  // 0: the next world step.
  SilencePolicy silence = SilencePolicy::wait;
  SimDuration wall_limit =
      SimDuration::from_ns(5'000'000'000);  // Of wall-clock time, before the policy acts.
};

// A sensor's clock and quality. A reading of time t reaches the behaviour at t + latency.
struct SensorSpec {
  SimDuration period = SimDuration::from_ns(8'000'000);
  SimDuration phase;  // Of the first reading.
  SimDuration latency;
  double sigma = 0;  // In the sensor's unit.
};

struct SensorsSpec {
  SensorSpec joints;                    // rad
  SensorSpec odometry;                  // Relative: sigma per root metre (and per root radian).
  SensorSpec accelerometer;             // m/s^2
  std::optional<SensorSpec> gyroscope;  // rad/s
  SensorSpec paws;                      // Contact switches: sigma is the chance of a wrong reading.
};

// A joint with a model of its own.
struct JointServo {
  std::string joint;
  std::string model_yaml, model_name;  // As CameraSpec's.
};

struct RobotSpec {
  std::string id;
  Team team = Team::red;
  int64_t number = 1;  // On the uniform, 1 to 11.
  std::string token;  // The secret with which its behaviour connects. Empty: derived by the server.
  Pose2 pose;
  RobotBody body;
  CameraSpec camera;
  BehaviourSpec behaviour;
  SensorsSpec sensors;
  std::vector<JointServo> servos;
  std::array<double, kHeadJoints> head_rad{0, 0, 0};  // Tilt, pan, roll at the start.
  double head_speed_radps =
      0;  // Replaces the head's top speeds when positive (the paper's 300 deg/s).
};

struct BallSpec {
  bool present = true;
  double x_m = 0, y_m = 0;
  double vx_mps = 0, vy_mps = 0;
  double diameter_m = 0.084;
  double mass_kg = 0.1;
  double rolling_deceleration_mps2 = 0.3;
  double restitution = 0.5;
};

struct RadioSpec {
  SimDuration latency = SimDuration::from_ns(20'000'000);
  double loss = 0;  // Chance that a message is lost.
  double range_m = 20;
  double bytes_per_s = 100000;  // Of each sender.
  int64_t max_message_bytes = 1024;
};

struct RefereeSpec {
  bool enabled = false;
  SimDuration half = SimDuration::from_ns(600'000'000'000);
  int64_t halves = 2;
  SimDuration ready = SimDuration::from_ns(15'000'000'000);  // Robots walk to their places.
  SimDuration set = SimDuration::from_ns(5'000'000'000);
  SimDuration penalty = SimDuration::from_ns(30'000'000'000);
  SimDuration holding = SimDuration::from_ns(3'000'000'000);  // Longest hold of the ball.
  SimDuration stuck =
      SimDuration::from_ns(20'000'000'000);  // Longest time without the ball moving.
  Team kick_off = Team::red;
};

// Whether a robot may be called so, in scenarios and in logs: names become names of files.
bool is_robot_id(std::string_view id);
inline constexpr const char* kRobotIdRule = "1 to 64 letters, digits, '_' or '-'";

struct Scenario {
  std::string name;
  std::string description;
  SimDuration duration = SimDuration::from_ns(10'000'000'000);
  int64_t seed = 1;
  SimDuration step = SimDuration::from_ns(8'000'000);  // World step; state is hashed at each.
  int64_t physics_substeps = 4;                        // Of equal length in each step.
  bool has_field = true;
  FieldSpec field;
  BallSpec ball;
  std::vector<RobotSpec> robots;
  RadioSpec radio;
  RefereeSpec referee;
  std::vector<ObjectSpec> objects;
  Rgb background_rgb{0.45, 0.45, 0.5};
  Lighting lighting;
  std::string supervisor_token;  // Empty: derived by the server.
  std::string render_token;

  // Throws InputError naming file, line and key.
  static Scenario from_file(const std::filesystem::path& path);
  static Scenario from_text(const std::string& yaml, const std::string& name);
  // Of a text that `to_yaml` wrote: errors name keys without lines, which stand in no file.
  static Scenario from_made_text(const std::string& yaml, const std::string& name);
  // The whole scenario in one document, files included: from_text gives an equal scenario.
  std::string to_yaml() const;
  // JSON Schema (docs/reference/schemas/scenario.schema.json).
  static std::string schema();

  // Warnings of those who read the robots' files, each once.
  std::vector<std::string> notes() const;

  // Index of the robot with this id, or robots.size().
  size_t robot_index(const std::string& id) const;
};

// The stream of everything random in a robot's camera.
RandomStream camera_stream(const Scenario& scenario, const RobotSpec& robot);

}  // namespace seam
