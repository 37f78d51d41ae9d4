#include "sim_core/world/physics.h"

#include <box2d/box2d.h>

#include <algorithm>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/world/box2d_maths.h"

namespace seam {
namespace {

// Box2D lengths per metre. Box2D lets bodies sink into each other by up to 3 of its linear slops
// (here 0.375 mm), and moves nothing farther than 2 of its lengths in a step (here 25 m/s in 2 ms).
constexpr double kScale = 40;
constexpr int kVelocityIterations = 8;
constexpr int kPositionIterations = 3;
// Slower contacts do not bounce, m/s; ends the ever smaller bounces of a ball at rest.
constexpr double kBounceThreshold = 0.02;

enum Category : uint16 {
  kFieldCategory = 1,
  kRobotCategory = 2,
  kBallCategory = 4,
  kLimbCategory = 8,
  kNothing = 0
};

float scaled(double metres) {
  return static_cast<float>(metres * kScale);
}
double metres(float length) {
  return static_cast<double>(length) / kScale;
}

// Fixture user data: who it is. 0 is the field, 1 the ball, 2 + i robot i (or its limb).
constexpr uintptr_t kBallTag = 1;
constexpr uintptr_t kFirstRobotTag = 2;

class ContactLog final : public b2ContactListener {
 public:
  void PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) override {
    uintptr_t a = contact->GetFixtureA()->GetUserData().pointer;
    uintptr_t b = contact->GetFixtureB()->GetUserData().pointer;
    if (b == kBallTag) std::swap(a, b);
    if (a != kBallTag || b < kFirstRobotTag || impulse->count == 0) return;
    const double strength = static_cast<double>(impulse->normalImpulses[0]) / kScale;
    if (strength > 0) contacts.push_back({static_cast<size_t>(b - kFirstRobotTag), strength});
  }
  std::vector<BallContact> contacts;
};

}  // namespace

void PlanarBody::visit(StateVisitor& visitor) {
  visitor.field("x_m", x_m);
  visitor.field("y_m", y_m);
  visitor.field("theta_rad", theta_rad);
  visitor.field("vx_mps", vx_mps);
  visitor.field("vy_mps", vy_mps);
  visitor.field("omega_radps", omega_radps);
  visitor.field("solid", solid);
}

class Physics::Impl {
 public:
  explicit Impl(const Scenario& s) : scenario(s) {
    SEAM_CHECK(box2d_sine(0) == 0);  // Links the sine and cosine that Box2D is to use.
  }

  void advance(PhysicsState& state, double h_s, int64_t substeps, const Hooks& hooks) {
    log.contacts.clear();
    b2World world(b2Vec2(0, 0));
    world.SetWarmStarting(false);
    world.SetAllowSleeping(false);
    world.SetContinuousPhysics(true);
    world.SetContactListener(&log);
    build(world, state);
    for (int64_t k = 0; k < substeps; ++k) {
      if (hooks.before) hooks.before(k, state);
      const bool stops = start_rolling(state.ball, h_s);
      put_velocities(state);
      world.Step(static_cast<float>(h_s), kVelocityIterations, kPositionIterations);
      const double speed_before = maths::length(state.ball.vx_mps, state.ball.vy_mps);
      read(state);
      end_rolling(state.ball, h_s, stops, speed_before);
      if (hooks.after) hooks.after(k, state);
    }
  }

  // Rolling friction, half before and half after the step, so that the way and the speed are those
  // of constant deceleration. Returns whether the ball comes to rest within the step by itself.
  bool start_rolling(PlanarBody& ball, double h_s) const {
    const double slower = scenario.ball.rolling_deceleration_mps2 * h_s;
    const double speed = maths::length(ball.vx_mps, ball.vy_mps);
    if (speed == 0) return true;
    const bool stops = speed <= slower;
    const double mean = stops ? speed * speed / (2 * slower) : speed - 0.5 * slower;
    ball.vx_mps *= mean / speed;
    ball.vy_mps *= mean / speed;
    return stops;
  }
  void end_rolling(PlanarBody& ball, double h_s, bool stops, double mean_speed) const {
    const double speed = maths::length(ball.vx_mps, ball.vy_mps);
    const double slower = 0.5 * scenario.ball.rolling_deceleration_mps2 * h_s;
    // A little more than it was given is rounding, not a push.
    const bool at_rest = speed <= slower || (stops && speed <= mean_speed + 1e-6);
    const double factor = at_rest ? 0 : 1 - slower / speed;
    ball.vx_mps *= factor;
    ball.vy_mps *= factor;
  }

  void build(b2World& world, const PhysicsState& state) {
    if (scenario.has_field) add_field(world);
    robots.clear();
    for (size_t i = 0; i < state.robots.size(); ++i)
      robots.push_back(add_robot(world, state.robots[i], i));
    ball = scenario.ball.present ? add_ball(world, state.ball) : nullptr;
    limbs.clear();
    for (const Limb& limb : state.limbs) limbs.push_back(add_limb(world, limb));
  }

  void add_field(b2World& world) {
    const FieldSpec& f = scenario.field;
    const b2BodyDef definition;
    b2Body* ground = world.CreateBody(&definition);
    b2FixtureDef fixture;
    fixture.friction = 0.3f;
    fixture.filter.categoryBits = kFieldCategory;
    const double x = f.half_length_m, y = f.half_width_m, g = 0.5 * f.goal_width_m, c = f.corner_m;
    const double back = x + f.goal_depth_m;
    const auto edge = [&](double x1, double y1, double x2, double y2) {
      b2EdgeShape shape;
      shape.SetTwoSided(b2Vec2(scaled(x1), scaled(y1)), b2Vec2(scaled(x2), scaled(y2)));
      shape.m_radius = 0;  // The wall is where it is, without a margin.
      fixture.shape = &shape;
      ground->CreateFixture(&fixture);
    };
    for (const double sy : {-1.0, 1.0}) edge(-x, sy * y, x, sy * y);
    for (const double sx : {-1.0, 1.0}) {
      for (const double sy : {-1.0, 1.0}) {
        edge(sx * x, sy * g, sx * x, sy * y);
        edge(sx * x, sy * (y - c), sx * (x - c), sy * y);
        edge(sx * x, sy * g, sx * back, sy * g);
      }
      edge(sx * back, -g, sx * back, g);
    }
    for (const double bx : {-f.beacon_x_m, 0.0, f.beacon_x_m}) {
      for (const double by : {-f.beacon_y_m, f.beacon_y_m}) {
        b2CircleShape shape;
        shape.m_radius = scaled(0.5 * f.beacon_diameter_m);
        shape.m_p.Set(scaled(bx), scaled(by));
        fixture.shape = &shape;
        ground->CreateFixture(&fixture);
      }
    }
  }

  b2Body* add_robot(b2World& world, const PlanarBody& state, size_t index) {
    const RobotBody& robot = scenario.robots[index].body;
    b2BodyDef definition;
    definition.type = b2_dynamicBody;
    definition.bullet = true;
    definition.position.Set(scaled(state.x_m), scaled(state.y_m));
    definition.angle = static_cast<float>(state.theta_rad);
    b2Body* body = world.CreateBody(&definition);
    b2PolygonShape box;
    const float skin = box.m_radius;
    box.SetAsBox(scaled(0.5 * robot.footprint_length_m) - skin,
                 scaled(0.5 * robot.footprint_width_m) - skin,
                 b2Vec2(scaled(robot.footprint_x_m), 0), 0);
    b2FixtureDef fixture;
    fixture.shape = &box;
    fixture.friction = 0.3f;
    fixture.density = static_cast<float>(robot.mass_kg) /
                      (scaled(robot.footprint_length_m) * scaled(robot.footprint_width_m));
    fixture.filter.categoryBits = kRobotCategory;
    fixture.filter.maskBits =
        state.solid ? kFieldCategory | kRobotCategory | kBallCategory : kNothing;
    fixture.userData.pointer = kFirstRobotTag + index;
    body->CreateFixture(&fixture);
    b2MassData mass = {static_cast<float>(robot.mass_kg), b2Vec2(0, 0), 0};
    const float length = scaled(robot.footprint_length_m), width = scaled(robot.footprint_width_m);
    mass.I = mass.mass * (length * length + width * width) / 12;
    body->SetMassData(&mass);
    return body;
  }

  b2Body* add_ball(b2World& world, const PlanarBody& state) {
    b2BodyDef definition;
    definition.type = b2_dynamicBody;
    definition.bullet = true;
    definition.fixedRotation = true;
    definition.position.Set(scaled(state.x_m), scaled(state.y_m));
    b2Body* body = world.CreateBody(&definition);
    b2CircleShape disc;
    disc.m_radius = scaled(0.5 * scenario.ball.diameter_m);
    b2FixtureDef fixture;
    fixture.shape = &disc;
    fixture.friction = 0;  // Mixed with others as the geometric mean: no friction at all.
    fixture.restitution =
        static_cast<float>(scenario.ball.restitution);        // Mixed as the larger one.
    fixture.restitutionThreshold = scaled(kBounceThreshold);  // Mixed as the smaller one.
    fixture.density =
        static_cast<float>(scenario.ball.mass_kg) / (b2_pi * disc.m_radius * disc.m_radius);
    fixture.filter.categoryBits = kBallCategory;
    fixture.filter.maskBits =
        state.solid ? kFieldCategory | kRobotCategory | kLimbCategory : kNothing;
    fixture.userData.pointer = kBallTag;
    body->CreateFixture(&fixture);
    return body;
  }

  b2Body* add_limb(b2World& world, const Limb& limb) {
    b2BodyDef definition;
    definition.type = b2_kinematicBody;
    definition.position.Set(scaled(limb.x_m), scaled(limb.y_m));
    b2Body* body = world.CreateBody(&definition);
    b2CircleShape disc;
    disc.m_radius = scaled(limb.radius_m);
    b2FixtureDef fixture;
    fixture.shape = &disc;
    fixture.filter.categoryBits = kLimbCategory;
    fixture.filter.maskBits = kBallCategory;
    fixture.userData.pointer = kFirstRobotTag + limb.robot;
    body->CreateFixture(&fixture);
    return body;
  }

  void put_velocities(const PhysicsState& state) {
    for (size_t i = 0; i < robots.size(); ++i) {
      const PlanarBody& robot = state.robots[i];
      robots[i]->SetLinearVelocity(b2Vec2(scaled(robot.vx_mps), scaled(robot.vy_mps)));
      robots[i]->SetAngularVelocity(static_cast<float>(robot.omega_radps));
    }
    if (ball != nullptr)
      ball->SetLinearVelocity(b2Vec2(scaled(state.ball.vx_mps), scaled(state.ball.vy_mps)));
    for (size_t i = 0; i < limbs.size(); ++i) {
      limbs[i]->SetLinearVelocity(
          b2Vec2(scaled(state.limbs[i].vx_mps), scaled(state.limbs[i].vy_mps)));
    }
  }

  void read(PhysicsState& state) const {
    const auto copy = [](const b2Body& body, PlanarBody& out) {
      out.x_m = metres(body.GetPosition().x);
      out.y_m = metres(body.GetPosition().y);
      out.theta_rad = static_cast<double>(body.GetAngle());
      out.vx_mps = metres(body.GetLinearVelocity().x);
      out.vy_mps = metres(body.GetLinearVelocity().y);
      out.omega_radps = static_cast<double>(body.GetAngularVelocity());
    };
    for (size_t i = 0; i < robots.size(); ++i) copy(*robots[i], state.robots[i]);
    if (ball != nullptr) copy(*ball, state.ball);
    for (size_t i = 0; i < limbs.size(); ++i) {
      state.limbs[i].x_m = metres(limbs[i]->GetPosition().x);
      state.limbs[i].y_m = metres(limbs[i]->GetPosition().y);
    }
  }

  const Scenario& scenario;
  ContactLog log;
  std::vector<b2Body*> robots;
  std::vector<b2Body*> limbs;
  b2Body* ball = nullptr;
};

Physics::Physics(const Scenario& scenario) : impl_(std::make_unique<Impl>(scenario)) {}
Physics::~Physics() = default;
Physics::Physics(Physics&&) noexcept = default;

void Physics::advance(PhysicsState& state, double h_s, int64_t substeps, const Hooks& hooks) {
  impl_->advance(state, h_s, substeps, hooks);
}

const std::vector<BallContact>& Physics::ball_contacts() const {
  return impl_->log.contacts;
}

}  // namespace seam
