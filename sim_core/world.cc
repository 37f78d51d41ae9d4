#include "sim_core/world.h"

#include <algorithm>
#include <cmath>

#include "sim_core/error.h"
#include "sim_core/hash.h"
#include "sim_core/maths.h"
#include "sim_core/robot.h"

namespace seam {
namespace {

constexpr uint16_t kBallId = 1;
constexpr uint16_t kFirstRobotId = 2;
constexpr uint16_t kFirstObjectId = 100;
constexpr uint16_t kFirstFieldId = 2000;

Label uniform_label(Team team) { return team == Team::red ? Label::robot_red : Label::robot_blue; }

// Turns the z axis to the normal, keeping the x axis horizontal.
Mat3 facing(const Vec3& normal) {
  const Vec3 z = glm::normalize(normal);
  if (std::abs(z.z) > 1 - 1e-12) return z.z > 0 ? Mat3(1.0) : Mat3(1, 0, 0, 0, -1, 0, 0, 0, -1);
  const Vec3 x = glm::normalize(glm::cross(Vec3(0, 0, 1), z));
  return Mat3(x, glm::cross(z, x), z);
}

}  // namespace

std::unique_ptr<JointActuator> RobotPartsFactory::joint(const RobotSpec&, int, double initial_rad, RandomStream) const {
  return limited_actuator(initial_rad);
}

std::unique_ptr<LocomotionModel> RobotPartsFactory::locomotion(const RobotSpec&, RandomStream) const {
  return std::make_unique<IdealLocomotion>();
}

struct BallState {
  std::vector<Vec3> points;  // At the ends of the interval's physics steps.
  Vec3 v{0.0};               // At the interval's end.

  void visit(StateVisitor& visitor) {
    for (Vec3& point : points) {
      visitor.field("x_m", point.x);
      visitor.field("y_m", point.y);
    }
    visitor.field("vx_mps", v.x);
    visitor.field("vy_mps", v.y);
  }
};

class World::Impl {
 public:
  Impl(const Scenario& s, const RobotPartsFactory& parts) : scenario(s) {
    const RandomStream root{static_cast<uint64_t>(s.seed), 0};
    const auto substeps = static_cast<size_t>(s.physics_substeps);
    for (const RobotSpec& spec : scenario.robots) {
      robots.emplace_back(spec, parts, root.child("robot").child(std::string_view(spec.id)), substeps);
    }
    const Vec3 place{s.ball.x_m, s.ball.y_m, 0.5 * s.ball.diameter_m};
    ball.points.assign(substeps + 1, place);
    ball.v = {s.ball.vx_mps, s.ball.vy_mps, 0};
    if (s.has_field) fixed = field_primitives(s.field, kFirstFieldId);
  }

  double fraction(SimTime time) const {
    if (end == start) return 1;
    return static_cast<double>((time - start).ns()) / static_cast<double>((end - start).ns());
  }

  Vec3 ball_at(SimTime time) const {
    const size_t pieces = ball.points.size() - 1;
    const double scaled = std::clamp(fraction(time), 0.0, 1.0) * static_cast<double>(pieces);
    const size_t i = std::min(static_cast<size_t>(scaled), pieces - 1);
    return ball.points[i] + (scaled - static_cast<double>(i)) * (ball.points[i + 1] - ball.points[i]);
  }

  void step() {
    start = end;
    end = start + scenario.step;
    for (Robot& robot : robots) robot.begin_interval(start, end);
    const SimDuration h = scenario.step / scenario.physics_substeps;
    ball.points.front() = ball.points.back();
    for (Robot& robot : robots) robot.track.points.front() = robot.track.points.back();
    for (int64_t k = 0; k < scenario.physics_substeps; ++k) move(start + h * k, h, static_cast<size_t>(k) + 1);
  }

  void move(SimTime time, SimDuration h, size_t point) {
    for (Robot& robot : robots) {
      const Pose2& from = robot.track.points[point - 1];
      robot.velocity = robot.drive(time, h);
      const double middle = from.theta_rad + 0.5 * robot.velocity.omega_radps * h.s();
      const double c = maths::cos(middle), s = maths::sin(middle);
      const BodyVelocity& v = robot.velocity;
      robot.track.points[point] = {from.x_m + h.s() * (c * v.vx_mps - s * v.vy_mps),
                                   from.y_m + h.s() * (s * v.vx_mps + c * v.vy_mps), from.theta_rad + h.s() * v.omega_radps};
    }
    const double speed = glm::length(ball.v);
    const double slower = std::max(0.0, speed - scenario.ball.rolling_deceleration_mps2 * h.s());
    const Vec3 before = ball.v;
    if (speed > 0) ball.v *= slower / speed;
    ball.points[point] = ball.points[point - 1] + 0.5 * h.s() * (before + ball.v);
  }

  void add_robot(const Robot& robot, uint16_t id, SimTime time, bool is_viewer, std::vector<Primitive>& out) const {
    const RobotBody& body = robot.spec().body;
    const Pose X_WB = robot.body_pose(robot.track.at(fraction(time)), time);
    const auto X_BLinks = link_poses(body, robot.joint_angles(time));
    const Rgb& uniform = robot.spec().team == Team::red ? body.red_rgb : body.blue_rgb;
    for (const BodyPart& part : body.parts) {
      if (is_viewer && (part.link == Link::head || part.link == Link::neck)) continue;
      const Pose X_LP = {rotation_zyx(part.rotate_rad.x, part.rotate_rad.y, part.rotate_rad.z), part.centre_m};
      const bool team = part.paint == Paint::team;
      out.push_back({.shape = part.shape,
                     .label = team ? uniform_label(robot.spec().team) : Label::robot_body,
                     .object_id = id,
                     .X_WO = X_WB * X_BLinks[static_cast<size_t>(part.link)] * X_LP,
                     .size = part.size_m,
                     .rgb = team ? uniform : body.body_rgb});
    }
  }

  void add_objects(SimTime time, std::vector<Primitive>& out) const {
    uint16_t id = kFirstObjectId;
    for (const ObjectSpec& object : scenario.objects) {
      const Mat3 R = object.shape == Shape::rectangle ? facing(object.normal) : Mat3(1.0);
      out.push_back({.shape = object.shape,
                     .label = object.label,
                     .object_id = id++,
                     .X_WO = {rotation_zyx(0, 0, object.yaw_rad) * R, object.centre_m + time.s() * object.velocity_mps},
                     .size = object.size_m,
                     .rgb = object.rgb});
    }
  }

  void visit_clock(StateVisitor& visitor) {
    visitor.field("start", start);
    visitor.field("end", end);
  }
  // Calls `section(name, visit)` for each part of the state, in the stated order.
  template <class Section>
  void for_each_section(Section section) {
    section("clock", [&](StateVisitor& v) { visit_clock(v); });
    section("ball", [&](StateVisitor& v) { ball.visit(v); });
    for (Robot& robot : robots) {
      section("robot/" + robot.spec().id, [&](StateVisitor& v) { robot.visit(v); });
    }
  }

  Scenario scenario;
  SimTime start, end;
  std::vector<Robot> robots;
  BallState ball;
  std::vector<Primitive> fixed;  // Field.
  std::vector<WorldEvent> events;
};

World::World(const Scenario& scenario, const RobotPartsFactory& parts) : impl_(std::make_unique<Impl>(scenario, parts)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const Scenario& World::scenario() const { return impl_->scenario; }
SimTime World::start() const { return impl_->start; }
SimTime World::end() const { return impl_->end; }

void World::apply(size_t robot, const RobotCommand& command, SimTime time) {
  SEAM_CHECK(time >= start() && time <= end(), "{} outside [{}, {}]", time.ns(), start().ns(), end().ns());
  impl_->robots.at(robot).apply(command, time, impl_->end);
}

void World::freeze(size_t robot, SimTime time) { impl_->robots.at(robot).freeze(time); }

void World::step() { impl_->step(); }

void World::place_robot(size_t robot, const Pose2& pose) { impl_->robots.at(robot).place(pose); }

void World::place_ball(double x_m, double y_m, double vx_mps, double vy_mps) {
  for (Vec3& point : impl_->ball.points) point = {x_m, y_m, point.z};
  impl_->ball.v = {vx_mps, vy_mps, 0};
}

Pose World::camera_link_pose(size_t index, SimTime time) const {
  const Robot& robot = impl_->robots.at(index);
  return robot.body_pose(robot.track.at(impl_->fraction(time)), time) *
         seam::camera_link_pose(robot.spec().body, robot.joint_angle(kTilt, time), robot.joint_angle(kPan, time),
                                robot.joint_angle(kRoll, time));
}

void World::primitives_at(SimTime time, std::vector<Primitive>& out, std::optional<size_t> viewer) const {
  out.insert(out.end(), impl_->fixed.begin(), impl_->fixed.end());
  impl_->add_objects(time, out);
  const BallSpec& ball = impl_->scenario.ball;
  if (ball.present) {
    out.push_back({.shape = Shape::sphere,
                   .label = Label::ball,
                   .object_id = kBallId,
                   .X_WO = translation(impl_->ball_at(time)),
                   .size = {0.5 * ball.diameter_m, 0, 0},
                   .rgb = impl_->scenario.field.colours.orange});
  }
  for (size_t i = 0; i < impl_->robots.size(); ++i) {
    impl_->add_robot(impl_->robots[i], static_cast<uint16_t>(kFirstRobotId + i), time, viewer == i, out);
  }
}

SensorReading World::sensors(size_t index, SimTime time) const {
  const Robot& robot = impl_->robots.at(index);
  SensorReading reading;
  reading.time = reading.joints_time = reading.odometry_time = reading.accelerometer_time = reading.paws_time = time;
  for (int j = 0; j < kJoints; ++j) reading.joints_rad[static_cast<size_t>(j)] = robot.encoder(j, time);
  const Pose2 now = robot.track.at(impl_->fraction(time));
  const Pose2& first = robot.spec().pose;
  const double c = maths::cos(first.theta_rad), s = maths::sin(first.theta_rad);
  const double dx = now.x_m - first.x_m, dy = now.y_m - first.y_m;
  reading.odometry = {c * dx + s * dy, -s * dx + c * dy, maths::wrap_angle(now.theta_rad - first.theta_rad)};
  reading.acceleration_B_mps2 = {0, 0, 9.81};
  reading.paw_contact = {true, true, true, true};
  return reading;
}

BallTruth World::ball(SimTime time) const { return {impl_->ball_at(time), impl_->ball.v}; }

RobotTruth World::robot(size_t index, SimTime time) const {
  const Robot& robot = impl_->robots.at(index);
  const Pose2 place = robot.track.at(impl_->fraction(time));
  return {place, robot.velocity, robot.body_pose(place, time), robot.joint_angles(time)};
}

std::vector<WorldEvent> World::take_events() { return std::exchange(impl_->events, {}); }

std::vector<StateSection> World::sections() const {
  std::vector<StateSection> sections;
  impl_->for_each_section([&](const std::string& name, const auto& visit) {
    StateLister lister;
    visit(lister);
    sections.push_back({name, lister.take()});
  });
  return sections;
}

std::vector<uint64_t> World::section_hashes() const {
  std::vector<uint64_t> hashes;
  impl_->for_each_section([&](const std::string&, const auto& visit) {
    Hasher hasher;
    StateHasher visitor(hasher);
    visit(visitor);
    hashes.push_back(hasher.digest());
  });
  return hashes;
}

std::vector<std::string> World::section_names() const {
  std::vector<std::string> names;
  impl_->for_each_section([&](const std::string& name, const auto&) { names.push_back(name); });
  return names;
}

void World::visit(StateVisitor& visitor) const {
  impl_->for_each_section([&](const std::string&, const auto& visit) { visit(visitor); });
}

uint64_t World::hash() const {
  Hasher hasher;
  for (const uint64_t section : section_hashes()) hasher.add(section);
  return hasher.digest();
}

std::string World::snapshot() const {
  SnapshotWriter writer;
  impl_->for_each_section([&](const std::string&, const auto& visit) { visit(writer); });
  return writer.take();
}

void World::restore(std::string_view bytes) {
  SnapshotReader reader(bytes);
  impl_->for_each_section([&](const std::string&, const auto& visit) { visit(reader); });
  reader.finish();
}

}  // namespace seam
