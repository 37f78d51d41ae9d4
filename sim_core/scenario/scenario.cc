#include "sim_core/scenario/scenario.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "sim_core/input/config_table.h"
#include "sim_core/input/shown_text.h"

namespace seam {
namespace {

constexpr size_t kMaxRobots = 64;
constexpr size_t kMaxObjects = 1000;
constexpr Range kPosition{-100, 100};
constexpr Range kHeading{-7, 7};

void describe_clock(ConfigTable& table, ClockSpec& clock) {
  table.seconds({"period_s", "Time between ticks, s."}, clock.period, {0.001, 100});
  table.seconds({"phase_s", "Time of tick 0, s."}, clock.phase, {0, 1000});
  table.number({"drift_ppm", "How much longer the period is, millionths."}, clock.drift_ppm,
               {-1e5, 1e5});
  table.seconds({"jitter_sigma_s", "Random displacement of each tick, one sigma, s."},
                clock.jitter_sigma, {0, 1});
}

void describe_camera(ConfigTable& table, CameraSpec& camera) {
  table.file_or_yaml(
      {"model",
       "Effects of this robot's camera, joints and gait: a seam-model/1 file or its content."},
      camera.model_yaml, camera.model_name);
  table.file_or_yaml(
      {"colour_table", "The colour detection table: a seam-colour-table/1 file or its content."},
      camera.colour_table_yaml, camera.colour_table_name);
  table.integer({"width_px", "Image width."}, camera.width_px, 8, 4096);
  table.integer({"height_px", "Image height."}, camera.height_px, 8, 4096);
  table.object({"clock", "The camera's own clock."},
               [&](ConfigTable& clock) { describe_clock(clock, camera.clock); });
  table.boolean(
      {"locked", "Frames are locked to the head's swing instead of the camera's own clock."},
      camera.locked);
  table.seconds({"lock_cycle_s", "The swing's period, s."}, camera.lock_cycle, {0.01, 1000});
  table.seconds({"lock_start_s", "When a swing starts, s."}, camera.lock_start, {0, 1000});
  table.integer({"lock_frames", "Frames a swing."}, camera.lock_frames, 1, 10000);
  table.integer(
      {"instants_per_row", "At least this many light samples fall into each row's exposure."},
      camera.instants_per_row, 1, 4096);
  table.boolean({"every_frame", "Deliver each frame without being asked."}, camera.every_frame);
}

void describe_behaviour(ConfigTable& table, BehaviourSpec& behaviour) {
  table.texts({"command",
               "Program and arguments that `seam run` starts; a bare name is looked up among the "
               "built behaviours."},
              behaviour.command);
  table.object({"clock", "When the behaviour is asked for decisions."},
               [&](ConfigTable& clock) { describe_clock(clock, behaviour.clock); });
  table.seconds({"decision_latency_s",
                 "From an observation to the decision's effect, s; 0: the next world step."},
                behaviour.decision_latency, {0, 10});
  table.choice_of(
      {"silence", "What happens when no decision comes: wait, freeze the robot, or abort the run."},
      behaviour.silence, {"wait", "freeze", "abort"});
  table.seconds({"wall_limit_s", "Wall-clock time before `silence` acts, s (wait never acts)."},
                behaviour.wall_limit, {0.001, 1e6});
}

void describe_sensor(ConfigTable& table, SensorSpec& sensor) {
  table.seconds({"period_s", "Time between readings, s."}, sensor.period, {0.001, 100});
  table.seconds({"phase_s", "Time of the first reading, s."}, sensor.phase, {0, 100});
  table.seconds({"latency_s", "From a reading to its delivery, s."}, sensor.latency, {0, 1});
  table.number({"sigma", "One sigma of its noise, in the sensor's unit."}, sensor.sigma, {0, 100});
}

// Robots have one where it is named.
void describe_gyroscope(ConfigTable& table, std::optional<SensorSpec>& gyroscope) {
  if (table.writes() && !gyroscope) return;
  table.object(
      {"gyroscope", "rad/s; a robot has one where this is there, `{}` at least."},
      [&](ConfigTable& t) {
        SensorSpec sensor = gyroscope.value_or(SensorSpec{});
        bool present = true;
        t.boolean({"present", "False: this robot has none, whatever others have."}, present);
        describe_sensor(t, sensor);
        gyroscope = present ? std::optional(sensor) : std::nullopt;
      });
}

void describe_sensors(ConfigTable& table, SensorsSpec& sensors) {
  table.object({"joints", "Joint encoders, rad."},
               [&](ConfigTable& t) { describe_sensor(t, sensors.joints); });
  table.object(
      {"odometry", "Dead reckoning; sigma per root metre walked and per root radian turned."},
      [&](ConfigTable& t) { describe_sensor(t, sensors.odometry); });
  table.object({"accelerometer", "m/s^2."},
               [&](ConfigTable& t) { describe_sensor(t, sensors.accelerometer); });
  describe_gyroscope(table, sensors.gyroscope);
  table.object({"paws", "Paw contacts; sigma is the chance of a wrong reading."},
               [&](ConfigTable& t) { describe_sensor(t, sensors.paws); });
}

void describe_pose(ConfigTable& table, Pose2& pose) {
  table.number({"x_m", "Towards the sky-blue goal, m.", true}, pose.x_m, kPosition);
  table.number({"y_m", "To the left, m.", true}, pose.y_m, kPosition);
  table.number({"theta_rad", "Heading, counter-clockwise from +x, rad."}, pose.theta_rad, kHeading);
}

void describe_servo(ConfigTable& table, JointServo& servo) {
  table.text({"joint", "The joint's name.", true}, servo.joint);
  table.file_or_yaml({"model", "Its effects: a seam-model/1 file or its content.", true},
                     servo.model_yaml, servo.model_name);
}

// What robots have in common; each robot overrides what it states.
void describe_common(ConfigTable& table, RobotSpec& robot) {
  table.file_or_object({"body", "What kind of robot: a seam-robot/1 file or its content."},
                       [&](ConfigTable& body) { describe(body, robot.body); });
  table.object({"camera", "Camera, effects and frame delivery."},
               [&](ConfigTable& t) { describe_camera(t, robot.camera); });
  table.object({"behaviour", "Who decides for it."},
               [&](ConfigTable& t) { describe_behaviour(t, robot.behaviour); });
  table.object({"sensors", "Clocks, latencies and noise of its sensors."},
               [&](ConfigTable& t) { describe_sensors(t, robot.sensors); });
  table.numbers({"head_rad", "Tilt, pan and roll at the start, rad."}, robot.head_rad);
  table.number({"head_speed_radps", "Replaces the head's top speeds where positive, rad/s."},
               robot.head_speed_radps, {0, 100});
  for (size_t j = 0; j < kHeadJoints && !robot.body.tree.present(); ++j) {
    const JointLimits& limits = robot.body.joints[j];
    table.require(robot.head_rad[j] >= limits.min_rad && robot.head_rad[j] <= limits.max_rad,
                  "head_rad",
                  fmt::format("found {} for {}, expected from {} to {}", robot.head_rad[j],
                              kJointNames[j], limits.min_rad, limits.max_rad));
  }
}

void describe_servos(ConfigTable& table, RobotSpec& robot) {
  if (robot.servos.empty() && table.writes()) return;
  table.list(
      {"servos", "Joints with models of their own, in place of the camera model's joint effects."},
      robot.servos.size(), kMostJoints, [&](size_t count) { robot.servos.resize(count); },
      [&](ConfigTable& t, size_t i) { describe_servo(t, robot.servos[i]); });
  for (const JointServo& servo : robot.servos) {
    bool known = false;
    for (size_t j = 0; j < robot.body.joint_count(); ++j)
      known = known || robot.body.joint_name(j) == servo.joint;
    table.require(known, "servos", fmt::format("the robot has no joint '{}'", shown(servo.joint)));
  }
}

void describe_robot(ConfigTable& table, RobotSpec& robot) {
  table.text({"id", "Its name: letters, digits, '_' and '-'.", true}, robot.id);
  table.require(is_robot_id(robot.id), "id",
                fmt::format("found '{}', expected {}", robot.id, kRobotIdRule));
  table.choice_of({"team", "Its team.", true}, robot.team, {"red", "blue"});
  table.integer({"number", "On the uniform."}, robot.number, 1, 64);
  table.text(
      {"token", "The secret with which its behaviour connects; left out: the server makes one."},
      robot.token);
  table.object({"pose", "Where it stands at the start.", true},
               [&](ConfigTable& t) { describe_pose(t, robot.pose); });
  describe_common(table, robot);
  describe_servos(table, robot);
  table.require(robot.body.tree.present() || robot.body.joints[kPan].speed_radps > 0, "body",
                "robot without a body: give 'body' here or in robot_defaults");
}

void describe_ball(ConfigTable& table, BallSpec& ball) {
  table.boolean({"present", "Whether there is a ball."}, ball.present);
  table.number({"x_m", "Where it lies at the start, m."}, ball.x_m, kPosition);
  table.number({"y_m", "Where it lies at the start, m."}, ball.y_m, kPosition);
  table.number({"vx_mps", "Its velocity at the start, m/s."}, ball.vx_mps, {-20, 20});
  table.number({"vy_mps", "Its velocity at the start, m/s."}, ball.vy_mps, {-20, 20});
  table.number({"diameter_m", "Diameter, m."}, ball.diameter_m, {0.01, 1});
  table.number({"mass_kg", "Mass, kg."}, ball.mass_kg, {0.001, 10});
  table.number({"rolling_deceleration_mps2", "How fast it slows while rolling, m/s^2."},
               ball.rolling_deceleration_mps2, {0, 20});
  table.number({"restitution", "Speed after a bounce over speed before, 0 to 1."}, ball.restitution,
               {0, 1});
}

void describe_radio(ConfigTable& table, RadioSpec& radio) {
  table.seconds({"latency_s", "From sending to receiving, s."}, radio.latency, {0, 10});
  table.number({"loss", "Chance that a message is lost."}, radio.loss, {0, 1});
  table.number({"range_m", "Farther team mates hear nothing, m."}, radio.range_m, {0, 1e6});
  table.number({"bytes_per_s", "Bandwidth of each sender; messages queue behind it."},
               radio.bytes_per_s, {1, 1e9});
  table.integer({"max_message_bytes", "Longer messages are refused."}, radio.max_message_bytes, 1,
                1 << 20);
}

void describe_referee(ConfigTable& table, RefereeSpec& referee) {
  table.boolean(
      {"enabled", "Whether the rules are enforced; otherwise play goes on from the start."},
      referee.enabled);
  table.seconds({"half_s", "Length of a half, s."}, referee.half, {1, 1e5});
  table.integer({"halves", "How many halves."}, referee.halves, 1, 10);
  table.seconds({"ready_s", "Time for robots to walk to their places, s."}, referee.ready,
                {0, 1000});
  table.seconds({"set_s", "Time of standing still before play, s."}, referee.set, {0, 1000});
  table.seconds({"penalty_s", "Time off the field, s."}, referee.penalty, {0, 1000});
  table.seconds({"holding_s", "Longest hold of the ball, s."}, referee.holding, {0, 1000});
  table.seconds({"stuck_s", "A ball that nobody moves for so long is put into the middle, s."},
                referee.stuck, {1, 1e5});
  table.choice_of({"kick_off", "Who has the first kick-off."}, referee.kick_off, {"red", "blue"});
}

void describe_lighting(ConfigTable& table, Lighting& lighting) {
  table.boolean(
      {"lambert", "Shade by the light's direction; otherwise each object shows its own colour."},
      lighting.lambert);
  table.vec3({"direction", "Towards the light; any length."}, lighting.direction_W);
  // Kept as it was written, so that a scenario which is written and read again is the same one.
  const double length = glm::length(lighting.direction_W);
  table.require(length > 0 && std::isfinite(length), "direction",
                "expected a direction, found a length of about 0");
  table.number({"ambient", "Light from all sides."}, lighting.ambient, {0, 10});
  table.number({"diffuse", "Light from that direction."}, lighting.diffuse, {0, 10});
}

void require_ids(ConfigTable& table, const std::vector<RobotSpec>& robots) {
  std::set<std::string> ids, tokens;
  for (const RobotSpec& robot : robots) {
    table.require(ids.insert(robot.id).second, "robots",
                  fmt::format("found two robots with the id '{}'", robot.id));
    table.require(robot.token.empty() || tokens.insert(robot.token).second, "robots",
                  fmt::format("robot '{}' has the token of another robot", robot.id));
  }
}

void describe_robots(ConfigTable& table, Scenario& scenario, RobotSpec& defaults) {
  table.list(
      {"robots", "The robots."}, scenario.robots.size(), kMaxRobots,
      [&](size_t count) { scenario.robots.assign(count, defaults); },
      [&](ConfigTable& t, size_t i) { describe_robot(t, scenario.robots[i]); });
  require_ids(table, scenario.robots);
}

void describe_surroundings(ConfigTable& table, Scenario& scenario) {
  table.boolean({"has_field", "Whether there is a field; otherwise only `objects` stand around."},
                scenario.has_field);
  table.file_or_object({"field", "The field: a seam-field/1 file or its content."},
                       [&](ConfigTable& t) { describe(t, scenario.field); });
  table.object({"ball", "The ball."}, [&](ConfigTable& t) { describe_ball(t, scenario.ball); });
  table.list(
      {"objects",
       "More objects to be seen, as in seam-scene/1; robots and ball pass through them."},
      scenario.objects.size(), kMaxObjects, [&](size_t count) { scenario.objects.resize(count); },
      [&](ConfigTable& t, size_t i) { describe(t, scenario.objects[i]); });
  table.numbers({"background_rgb", "What is seen where nothing stands, linear 0 to 1."},
                scenario.background_rgb);
  table.object({"lighting", "Shading."},
               [&](ConfigTable& t) { describe_lighting(t, scenario.lighting); });
}

// `with_defaults`: the key robot_defaults exists in files that people write; a written scenario
// states everything in each robot.
void describe_scenario(ConfigTable& table, Scenario& scenario, bool with_defaults) {
  table.format("seam-scenario/1");
  table.text({"name", "A short name."}, scenario.name);
  table.text({"description", "What it is for."}, scenario.description);
  table.seconds({"duration_s", "Length of the run in simulated time, s.", true}, scenario.duration,
                {0.001, 1e6});
  table.integer({"seed", "Of all randomness."}, scenario.seed, 0,
                std::numeric_limits<int64_t>::max());
  table.seconds({"step_s", "World step, s."}, scenario.step, {0.0001, 0.1});
  table.integer({"physics_substeps", "Physics steps in each world step."},
                scenario.physics_substeps, 1, 1000);
  const SimDuration substep = scenario.step / scenario.physics_substeps;
  table.require(substep * scenario.physics_substeps == scenario.step, "physics_substeps",
                "expected a divisor of the step in nanoseconds");
  table.require(substep <= SimDuration::from_ns(2'500'000), "physics_substeps",
                "expected so many that a physics step is at most 2.5 ms");
  describe_surroundings(table, scenario);
  RobotSpec defaults;
  if (with_defaults) {
    table.object({"robot_defaults", "What robots have in common; each robot may override it."},
                 [&](ConfigTable& t) { describe_common(t, defaults); });
  }
  describe_robots(table, scenario, defaults);
  table.object({"radio", "The radio between team mates."},
               [&](ConfigTable& t) { describe_radio(t, scenario.radio); });
  table.object({"referee", "The rules."},
               [&](ConfigTable& t) { describe_referee(t, scenario.referee); });
  table.text({"supervisor_token", "The secret of the supervisor; left out: the server makes one."},
             scenario.supervisor_token);
  table.text({"render_token",
              "The secret of the operator's rendering processes; left out: the server makes one."},
             scenario.render_token);
}

Scenario from_node(const ConfigNode& root) {
  root.at("format");
  Scenario scenario;
  read_config(root, [&](ConfigTable& table) { describe_scenario(table, scenario, true); });
  return scenario;
}

}  // namespace

bool is_robot_id(std::string_view id) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  return !id.empty() && id.size() <= 64 && id.find_first_not_of(kPlain) == std::string_view::npos;
}

Scenario Scenario::from_file(const std::filesystem::path& path) {
  Scenario scenario = from_node(ConfigNode::from_file(path));
  // Programs beside the scenario, as its other files are. In this folder they are found as they
  // are.
  const std::filesystem::path folder = path.parent_path();
  for (RobotSpec& robot : scenario.robots) {
    if (robot.behaviour.command.empty() || folder.empty()) continue;
    std::string& program = robot.behaviour.command.front();
    std::error_code unknown;
    if (program.find('/') != std::string::npos && program.front() != '/' &&
        std::filesystem::exists(folder / program, unknown))
      program = (folder / program).string();
  }
  return scenario;
}

Scenario Scenario::from_text(const std::string& yaml, const std::string& name) {
  return from_node(ConfigNode::from_text(yaml, name));
}

Scenario Scenario::from_made_text(const std::string& yaml, const std::string& name) {
  return from_node(ConfigNode::from_made_text(yaml, name));
}

std::string Scenario::to_yaml() const {
  Scenario copy = *this;
  return write_config([&](ConfigTable& table) { describe_scenario(table, copy, false); });
}

std::string Scenario::schema() {
  Scenario scenario;
  return config_schema("SEAM scenario",
                       [&](ConfigTable& table) { describe_scenario(table, scenario, true); });
}

std::vector<std::string> Scenario::notes() const {
  std::vector<std::string> all;
  for (const RobotSpec& robot : robots)
    for (const std::string& note : robot.body.notes)
      if (std::find(all.begin(), all.end(), note) == all.end()) all.push_back(note);
  return all;
}

size_t Scenario::robot_index(const std::string& id) const {
  for (size_t i = 0; i < robots.size(); ++i) {
    if (robots[i].id == id) return i;
  }
  return robots.size();
}

RandomStream camera_stream(const Scenario& scenario, const RobotSpec& robot) {
  const RandomStream root{static_cast<uint64_t>(scenario.seed), 0};
  return root.child("camera").child(robot.id);
}

}  // namespace seam
