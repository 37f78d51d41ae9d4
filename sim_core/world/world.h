// The world of a scenario: ball, robots and field, advanced in fixed steps, each of which fixes the
// state as a function of continuous time over the interval that follows.
//
// Use: at each multiple of the step, `apply` the commands due, then `step()`. The first `step()`
// makes the interval [0, step], the next [step, 2 step], and so on. Between, `apply` may be called
// with times inside the interval (the head follows at once, legs and body from the next step), and
// the state may be asked for any time in [start(), end()].
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim_core/body/command.h"
#include "sim_core/body/state.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/scene/scene.h"
#include "sim_core/world/radio.h"
#include "sim_core/world/referee.h"
#include "sim_core/world/sensors.h"

namespace seam {

// Makes the parts of a robot whose behaviour a model may change. sim_core/ brings joints with
// speed limits and ideal walking; effects/ brings those of the catalogue.
class RobotPartsFactory {
 public:
  virtual ~RobotPartsFactory() = default;
  // `joint` is an index of joints.h; `noise` is this joint's own stream.
  virtual std::unique_ptr<JointActuator> joint(const RobotSpec& robot, int joint,
                                               double initial_rad, RandomStream noise) const;
  virtual std::unique_ptr<LocomotionModel> locomotion(const RobotSpec& robot,
                                                      RandomStream noise) const;
  // None: they read what is there.
  virtual std::shared_ptr<const InertialReading> accelerometer(const RobotSpec&,
                                                               RandomStream) const {
    return nullptr;
  }
  virtual std::shared_ptr<const InertialReading> gyroscope(const RobotSpec&, RandomStream) const {
    return nullptr;
  }
};

struct BallTruth {
  Vec3 p_W{0.0};
  Vec3 v_W{0.0};
};

struct RobotTruth {
  Pose2 pose;             // The body's origin on the ground.
  BodyVelocity velocity;  // In the body's frame.
  bool on_field = true;   // False: penalised, beside the field.
  Pose X_WB;              // With height, pitch and sway.
  JointAngles joints_rad{};
};

// Another robot than the last one touched the ball: an event of earlier logs, which several robots
// at the ball repeat each step. The world still has it, so that those logs are made again as they
// are.
inline constexpr const char* kOldTouch = "ball_touched";
// A contact of a robot with the ball, from its first touch until it has not touched for a while.
inline constexpr const char* kContact = "ball_contact";
inline constexpr const char* kContactEnd = "ball_contact_end";

// Something that happened in the world, for the log and the referee.
struct WorldEvent {
  SimTime time;
  // World: "kick", "grab", "release", "ball_lost", "ball_contact" and "ball_contact_end" of a
  // robot; kOldTouch. Referee: see referee.h. Radio: "radio_sent".
  std::string kind;
  int robot = -1;      // Whose; -1: nobody's.
  std::string detail;  // For people.
  enum class Source : uint8_t { world, referee, radio } source = Source::world;
};

class World {
 public:
  // `model` in the scenario is not read here: its effects come in through `parts`, which is used
  // by the constructor only.
  explicit World(const Scenario& scenario, const RobotPartsFactory& parts = RobotPartsFactory());
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  const Scenario& scenario() const;
  SimTime start() const;  // Of the current interval.
  SimTime end() const;    // When the next step is due.

  // The command must be valid (`invalid_field`) and `time` inside [start(), end()].
  void apply(size_t robot, const RobotCommand& command, SimTime time);
  // Stands still and keeps its joints where they are.
  void freeze(size_t robot, SimTime time);
  void step();

  // For the supervisor; act from end() on.
  void place_robot(size_t robot, const Pose2& pose);
  void place_ball(double x_m, double y_m, double vx_mps, double vy_mps);

  // X_WL: the last link of the head at the camera (x along the optical axis, y left, z up). The
  // camera's pose is X_WC = X_WL * effects::mount_of(model).
  Pose camera_link_pose(size_t robot, SimTime time) const;
  // Field, objects, ball and robots, in this order, appended to `out`.
  void primitives_at(SimTime time, std::vector<Primitive>& out) const;
  // What of them stands still: the first ones.
  const std::vector<Primitive>& scenery() const;
  // What of the others a robot's camera, at X_LC in the last link of its head, has before it. Its
  // own head is left out, for the camera sits in it, and so are robots behind the camera. The
  // figures are the world's.
  SceneInstant view_of(size_t robot, SimTime time, const Pose& X_LC) const;
  Rgb background() const { return scenario().background_rgb; }
  Lighting lighting() const { return scenario().lighting; }

  // What the robot's sensors have delivered by `time`; `joint_log` holds the encoder readings that
  // were delivered after `since`, which must not lie farther back than its behaviour's period.
  RobotSensors sensors(size_t robot, SimTime time, SimTime since) const;
  // From now on the other robots' sensors are not read, which changes nothing else: for whoever
  // looks at one robot alone. Their `sensors` are empty, and the state no longer that of a run.
  void sense_only(size_t robot);

  // Over the radio to all team mates. Whoever calls this has refused longer messages than the
  // scenario's `max_message_bytes`.
  void send_radio(size_t from, const std::string& payload, SimTime time);
  // What arrived after `since`, not farther back than the behaviour's period, and by `time`.
  std::vector<RadioMessage> radio_received(size_t to, SimTime time, SimTime since) const;

  GameState game_state(size_t robot, SimTime time) const;
  void set_play_state(PlayState state);  // The supervisor's word; acts from end() on.
  int score(Team team) const;

  // Ground truth, for the supervisor, the log and tests.
  BallTruth ball(SimTime time) const;
  RobotTruth robot(size_t robot, SimTime time) const;
  // What happened since the last call, in order.
  std::vector<WorldEvent> take_events();

  // The state in sections ("ball", "robot/ID", ...), each with named fields, in a stated order.
  std::vector<StateSection> sections() const;
  // In the order of `sections()`, without the cost of names. The memory of `used` is used again.
  StateDigest digest(StateDigest used = {}) const;
  std::vector<std::string> section_names() const;
  // All fields in the order of `sections()`, for visitors that read only.
  void visit(StateVisitor& visitor) const;
  // Over the section hashes in order.
  uint64_t hash() const;

  // The whole state as canonical bytes; `restore` into a world of the same scenario and parts
  // continues to the same bits. Throws InputError for bytes of another scenario.
  std::string snapshot() const;
  void restore(std::string_view bytes);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace seam
