#include "sim_core/world/world.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/maths.h"
#include "sim_core/world/world_impl.h"

namespace seam {
namespace {

// Paws and heads of robots nearer to the ball can push it, m.
constexpr double kLimbDistance = 0.45;
// The front of the head, in its frame, as a disc seen from above.
constexpr double kNoseForward = 0.045;
constexpr double kNoseRadius = 0.03;

std::vector<std::string> ids_of(const Scenario& scenario) {
  std::vector<std::string> ids;
  for (const RobotSpec& robot : scenario.robots) ids.push_back(robot.id);
  return ids;
}

std::vector<Team> teams_of(const Scenario& scenario) {
  std::vector<Team> teams;
  for (const RobotSpec& robot : scenario.robots) teams.push_back(robot.team);
  return teams;
}

// No two observations of a robot lie farther apart.
SimDuration longest_turn_of(const ClockSpec& clock) {
  return SimDuration::from_s(clock.period.s() * (1 + std::abs(clock.drift_ppm) * 1e-6)) +
         clock.jitter_sigma * 18 + SimDuration::from_ns(1'000'000);
}

RandomStream root_of(const Scenario& scenario) {
  return {static_cast<uint64_t>(scenario.seed), 0};
}

}  // namespace

std::unique_ptr<JointActuator> RobotPartsFactory::joint(const RobotSpec&, int, double initial_rad,
                                                        RandomStream) const {
  return limited_actuator(initial_rad);
}

std::unique_ptr<LocomotionModel> RobotPartsFactory::locomotion(const RobotSpec&,
                                                               RandomStream) const {
  return std::make_unique<IdealLocomotion>();
}

World::Impl::Impl(const Scenario& given, const RobotPartsFactory& parts)
    : scenario(given),
      physics(scenario),
      ball_play(scenario, root_of(scenario).child("kicks")),
      referee(scenario),
      radio(scenario.radio, ids_of(scenario), teams_of(scenario),
            root_of(scenario).child("radio")) {
  // A scenario keeps its direction as it was written; a world's is of length 1.
  scenario.lighting.direction_W /= glm::length(scenario.lighting.direction_W);
  const auto substeps = static_cast<size_t>(scenario.physics_substeps);
  for (const RobotSpec& spec : scenario.robots) {
    const RandomStream stream = root_of(scenario).child("robot").child(std::string_view(spec.id));
    robots.emplace_back(spec, parts, stream, substeps);
    const SimDuration turn = longest_turn_of(spec.behaviour.clock);
    sensors.emplace_back(spec, turn, stream, parts);
    longest_turn = std::max(longest_turn, turn);
    bodies.robots.push_back({spec.pose.x_m, spec.pose.y_m, spec.pose.theta_rad});
  }
  const BallSpec& ball = scenario.ball;
  bodies.ball = {ball.x_m, ball.y_m, 0, ball.vx_mps, ball.vy_mps, 0};
  ball_points.assign(substeps + 1, Vec3(ball.x_m, ball.y_m, 0.5 * ball.diameter_m));
  make_scenery();
}

double World::Impl::fraction(SimTime time) const {
  if (end == start) return 1;
  return static_cast<double>((time - start).ns()) / static_cast<double>((end - start).ns());
}

Vec3 World::Impl::ball_at(SimTime time) const {
  const size_t pieces = ball_points.size() - 1;
  const double scaled = std::clamp(fraction(time), 0.0, 1.0) * static_cast<double>(pieces);
  const size_t i = std::min(static_cast<size_t>(scaled), pieces - 1);
  return ball_points[i] + (scaled - static_cast<double>(i)) * (ball_points[i + 1] - ball_points[i]);
}

std::vector<Pose2> World::Impl::places(SimTime time) const {
  std::vector<Pose2> places;
  for (const Robot& robot : robots) places.push_back(robot.track.at(fraction(time)));
  return places;
}

void World::Impl::sample(SensorSuite& suite, size_t robot, SimTime time, SimTime since) const {
  for (const SimTime tick : suite.sampling_times(since, time)) {
    suite.sample(tick, robots[robot].sense(tick, fraction(tick), scenario.step));
  }
}

void World::Impl::step() {
  for (size_t i = 0; i < robots.size(); ++i) {
    if (is_sensed(i)) sample(sensors[i], i, end, sampled_until());
  }
  radio.forget_before(end - longest_turn);
  follow_referee();
  start = end;
  end = start + scenario.step;
  for (Robot& robot : robots) robot.begin_interval(start, end);
  for (size_t i = 0; i < robots.size(); ++i)
    bodies.robots[i].theta_rad = robots[i].track.points.front().theta_rad;
  ball_points.front() = ball_points.back();
  find_limbs();
  const SimDuration h = scenario.step / scenario.physics_substeps;
  const Physics::Hooks hooks = {
      .before =
          [&](int64_t k, PhysicsState&) {
            drive_robots(k, start + h * k, h);
            move_limbs(start + h * k, h);
            ball_play.act(start + h * k, h, bodies, events);
          },
      .after =
          [&](int64_t k, const PhysicsState&) {
            const auto point = static_cast<size_t>(k) + 1;
            for (size_t i = 0; i < robots.size(); ++i) {
              const PlanarBody& body = bodies.robots[i];
              robots[i].track.points[point] = {body.x_m, body.y_m, body.theta_rad};
            }
            ball_points[point].x = bodies.ball.x_m;
            ball_points[point].y = bodies.ball.y_m;
          }};
  physics.advance(bodies, h.s(), scenario.physics_substeps, hooks);
  for (Robot& robot : robots) robot.end_interval();
  note_touches();
}

void World::Impl::follow_referee() {
  RefereeView view{.time = end,
                   .ball_x_m = bodies.ball.x_m,
                   .ball_y_m = bodies.ball.y_m,
                   .robots = places(end),
                   .ball_holder = ball_play.holder()};
  const RefereeOrders orders = referee.judge(view);
  for (const auto& placement : orders.robots) {
    place_robot(placement.robot, placement.pose, placement.on_field);
  }
  if (orders.place_ball) place_ball(orders.ball_x_m, orders.ball_y_m, 0, 0);
  for (const auto& event : orders.events) {
    events.push_back({end, event.kind, event.robot, event.detail, WorldEvent::Source::referee});
  }
}

// Robots go where their legs carry them; Box2D keeps them apart.
void World::Impl::drive_robots(int64_t substep, SimTime time, SimDuration h) {
  for (size_t i = 0; i < robots.size(); ++i) {
    PlanarBody& body = bodies.robots[i];
    const bool may_walk = referee.may_move(i) && !ball_play.busy(i, time);
    const BodyVelocity v = robots[i].drive(static_cast<size_t>(substep), time, h, may_walk);
    const Pose2 from{body.x_m, body.y_m, body.theta_rad};
    const Pose2 to = moved(from, v, h.s());
    body.vx_mps = (to.x_m - from.x_m) / h.s();
    body.vy_mps = (to.y_m - from.y_m) / h.s();
    body.omega_radps = v.omega_radps;
  }
}

// Front paws and lowered heads of robots near the ball.
void World::Impl::find_limbs() {
  bodies.limbs.clear();
  if (!scenario.ball.present || !bodies.ball.solid) return;
  for (size_t i = 0; i < robots.size(); ++i) {
    const double dx = bodies.robots[i].x_m - bodies.ball.x_m,
                 dy = bodies.robots[i].y_m - bodies.ball.y_m;
    if (robots[i].spec().body.tree.present()) continue;  // Its footprint alone touches.
    if (!bodies.robots[i].solid || dx * dx + dy * dy > kLimbDistance * kLimbDistance) continue;
    const Pose X_WB = robots[i].body_pose(robots[i].track.points.front(), 0);
    const auto paws = robots[i].paws(start);
    for (size_t paw = 0; paw < 2; ++paw) {
      const Vec3 p = X_WB * paws[paw];
      bodies.limbs.push_back({i, p.x, p.y, 0, 0, robots[i].spec().body.paw_radius_m});
    }
    const JointAngles joints = robots[i].joint_angles(start);
    const Vec3 nose = X_WB *
                      head_pose(robots[i].spec().body, joints[kTilt], joints[kPan], joints[kRoll]) *
                      Vec3(kNoseForward, 0, 0);
    const bool low = nose.z - kNoseRadius < scenario.ball.diameter_m;
    if (low) bodies.limbs.push_back({i, nose.x, nose.y, 0, 0, kNoseRadius});
  }
}

// Gives each limb the velocity that takes it to where its robot has it at the end of the substep.
void World::Impl::move_limbs(SimTime time, SimDuration h) {
  size_t of_robot = 0;  // Which limb of its robot: two paws, then the nose.
  for (size_t l = 0; l < bodies.limbs.size(); ++l) {
    Limb& limb = bodies.limbs[l];
    of_robot = l > 0 && bodies.limbs[l - 1].robot == limb.robot ? of_robot + 1 : 0;
    const PlanarBody& body = bodies.robots[limb.robot];
    const Robot& robot = robots[limb.robot];
    const Pose2 place{body.x_m + h.s() * body.vx_mps, body.y_m + h.s() * body.vy_mps,
                      body.theta_rad + h.s() * body.omega_radps};
    const Pose X_WB = robot.body_pose(place, fraction(time + h));
    Vec3 p;
    if (of_robot < 2) {
      p = X_WB * robot.paws(time + h)[of_robot];
    } else {
      const JointAngles joints = robot.joint_angles(time + h);
      p = X_WB * head_pose(robot.spec().body, joints[kTilt], joints[kPan], joints[kRoll]) *
          Vec3(kNoseForward, 0, 0);
    }
    limb.vx_mps = (p.x - limb.x_m) / h.s();
    limb.vy_mps = (p.y - limb.y_m) / h.s();
  }
}

void World::Impl::place_robot(size_t i, const Pose2& pose, bool on_field) {
  robots[i].place(pose);
  bodies.robots[i] = {pose.x_m, pose.y_m, pose.theta_rad};
  bodies.robots[i].solid = on_field;
  ball_play.let_go(i);
}

void World::Impl::place_ball(double x_m, double y_m, double vx_mps, double vy_mps) {
  for (Vec3& point : ball_points) point = {x_m, y_m, point.z};
  bodies.ball = {x_m, y_m, 0, vx_mps, vy_mps, 0};
  for (size_t i = 0; i < robots.size(); ++i) ball_play.let_go(i);
}

void World::Impl::visit_ball(StateVisitor& visitor) {
  bodies.ball.visit(visitor);
  for (Vec3& point : ball_points) {
    visitor.field("track_x_m", point.x);
    visitor.field("track_y_m", point.y);
  }
  visitor.field("last_touch", last_touch);
}

World::World(const Scenario& scenario, const RobotPartsFactory& parts)
    : impl_(std::make_unique<Impl>(scenario, parts)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

const Scenario& World::scenario() const {
  return impl_->scenario;
}
SimTime World::start() const {
  return impl_->start;
}
SimTime World::end() const {
  return impl_->end;
}

void World::apply(size_t robot, const RobotCommand& command, SimTime time) {
  SEAM_CHECK(time >= start() && time <= end(), "{} outside [{}, {}]", time.ns(), start().ns(),
             end().ns());
  Robot& commanded = impl_->robots.at(robot);
  commanded.apply(command, time, impl_->end);
  if (command.kick == Kick::none || !impl_->referee.may_move(robot)) return;
  if (impl_->ball_play.request(robot, command.kick, time)) {
    commanded.begin_kick(commanded.spec().body.kick(command.kick), time, impl_->end);
  }
}

void World::freeze(size_t robot, SimTime time) {
  impl_->robots.at(robot).freeze(time);
}

void World::step() {
  impl_->step();
}

void World::place_robot(size_t robot, const Pose2& pose) {
  SEAM_CHECK(robot < impl_->robots.size(), "robot {}", robot);
  impl_->place_robot(robot, pose, true);
}

void World::place_ball(double x_m, double y_m, double vx_mps, double vy_mps) {
  impl_->place_ball(x_m, y_m, vx_mps, vy_mps);
}

void World::sense_only(size_t robot) {
  impl_->sensed = robot;
}

RobotSensors World::sensors(size_t robot, SimTime time, SimTime since) const {
  if (!impl_->is_sensed(robot)) return {};
  const SensorSuite& suite = impl_->sensors.at(robot);
  const SimTime sampled = impl_->sampled_until();
  if (suite.sampling_times(sampled, time).empty()) return suite.read(time, since);
  SensorSuite ahead = suite;  // Of the current interval; the world itself samples it at its end.
  impl_->sample(ahead, robot, time, sampled);
  return ahead.read(time, since);
}

// One event a message: who is to get it and who will not.
void World::send_radio(size_t from, const std::string& payload, SimTime time) {
  static constexpr std::array<const char*, 4> kFates = {"", " (lost)", " (out of range)",
                                                        " (queue full)"};
  std::string detail = fmt::format("{} bytes to", payload.size());
  for (const auto& [to, fate] : impl_->radio.send(from, payload, time, impl_->places(time))) {
    detail +=
        fmt::format(" {}{}", impl_->scenario.robots[to].id, kFates[static_cast<size_t>(fate)]);
  }
  impl_->events.push_back(
      {time, "radio_sent", static_cast<int>(from), detail, WorldEvent::Source::radio});
}

std::vector<RadioMessage> World::radio_received(size_t to, SimTime time, SimTime since) const {
  return impl_->radio.received(to, time, since);
}

GameState World::game_state(size_t robot, SimTime time) const {
  return impl_->referee.game_state(robot, time);
}

void World::set_play_state(PlayState state) {
  impl_->referee.set_state(state, impl_->end);
  impl_->events.push_back(
      {impl_->end, to_string(state), -1, "by the supervisor", WorldEvent::Source::referee});
}

int World::score(Team team) const {
  return impl_->referee.score(team);
}

BallTruth World::ball(SimTime time) const {
  return {impl_->ball_at(time), {impl_->bodies.ball.vx_mps, impl_->bodies.ball.vy_mps, 0}};
}

RobotTruth World::robot(size_t index, SimTime time) const {
  const Robot& robot = impl_->robots.at(index);
  const PlanarBody& body = impl_->bodies.robots[index];
  const Pose2 place = robot.track.at(impl_->fraction(time));
  const double c = maths::cos(place.theta_rad), s = maths::sin(place.theta_rad);
  const BodyVelocity velocity{c * body.vx_mps + s * body.vy_mps, c * body.vy_mps - s * body.vx_mps,
                              body.omega_radps};
  return {place, velocity, body.solid, robot.body_pose(place, impl_->fraction(time)),
          robot.joint_angles(time)};
}

std::vector<WorldEvent> World::take_events() {
  return std::exchange(impl_->events, {});
}

std::vector<StateSection> World::sections() const {
  std::vector<StateSection> sections;
  impl_->for_each_section([&](const std::string& name, const auto& visit) {
    StateLister lister;
    visit(lister);
    sections.push_back({name, lister.take()});
  });
  return sections;
}

StateDigest World::digest(StateDigest used) const {
  StateDigest digest = std::move(used);
  digest.section_hashes.clear();
  StateWords words(std::move(digest.words));
  impl_->for_each_section([&](const std::string&, const auto& visit) {
    const size_t begin = words.words().size();
    visit(words);
    digest.section_hashes.push_back(words.hash(begin));
  });
  digest.words = words.take();
  return digest;
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
  for (const uint64_t section : digest().section_hashes) hasher.add(section);
  return hasher.digest();
}

std::string World::snapshot() const {
  SnapshotWriter writer;
  visit(writer);
  return writer.take();
}

void World::restore(std::string_view bytes) {
  impl_->touches.clear();
  SnapshotReader reader(bytes);
  visit(reader);
  reader.finish();
}

}  // namespace seam
