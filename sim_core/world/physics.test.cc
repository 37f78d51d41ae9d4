#include "sim_core/world/physics.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam {
namespace {

const std::string kPhysicsSource = SEAM_SOURCE_DIR;

// A field (or none) with `robots` robots of the ERS-210's size, and a ball.
Scenario scene(bool field, size_t robots, double deceleration, double restitution) {
  Scenario s = Scenario::from_file(kPhysicsSource + "/scenarios/head_swing.yaml");
  s.has_field = field;
  s.robots.resize(robots, s.robots.at(0));
  s.ball.rolling_deceleration_mps2 = deceleration;
  s.ball.restitution = restitution;
  return s;
}

double energy(const Scenario& s, const PhysicsState& state) {
  const auto part = [](const PlanarBody& b, double mass, double inertia) {
    return 0.5 * mass * (b.vx_mps * b.vx_mps + b.vy_mps * b.vy_mps) +
           0.5 * inertia * b.omega_radps * b.omega_radps;
  };
  double sum = part(state.ball, s.ball.mass_kg, 0);
  for (size_t i = 0; i < state.robots.size(); ++i) {
    const RobotBody& body = s.robots[i].body;
    const double length = body.footprint_length_m, width = body.footprint_width_m;
    const double inertia = body.mass_kg * (length * length + width * width) / 12;
    sum += part(state.robots[i], body.mass_kg, inertia);
  }
  return sum;
}

// Linear, and angular about the field's middle.
struct Momentum {
  double x_ns = 0, y_ns = 0, spin_nms = 0;
};

Momentum momentum(const Scenario& s, const PhysicsState& state) {
  Momentum sum;
  const auto add = [&](const PlanarBody& b, double mass, double inertia) {
    sum.x_ns += mass * b.vx_mps;
    sum.y_ns += mass * b.vy_mps;
    sum.spin_nms += mass * (b.x_m * b.vy_mps - b.y_m * b.vx_mps) + inertia * b.omega_radps;
  };
  add(state.ball, s.ball.mass_kg, 0);
  for (size_t i = 0; i < state.robots.size(); ++i) {
    const RobotBody& body = s.robots[i].body;
    const double length = body.footprint_length_m, width = body.footprint_width_m;
    add(state.robots[i], body.mass_kg, body.mass_kg * (length * length + width * width) / 12);
  }
  return sum;
}

// The dynamic linker gives Box2D our functions instead of libm's, whose bits depend on the CPU.
TEST(Physics, Box2dUsesOurSineAndCosine) {
  EXPECT_EQ(dlsym(RTLD_DEFAULT, "sinf"),
            reinterpret_cast<void*>(static_cast<float (*)(float)>(&::sinf)));
  EXPECT_EQ(dlsym(RTLD_DEFAULT, "cosf"),
            reinterpret_cast<void*>(static_cast<float (*)(float)>(&::cosf)));
  for (const char* name : {"sinf", "cosf", "sincosf"}) {
    Dl_info info;
    ASSERT_NE(dladdr(dlsym(RTLD_DEFAULT, name), &info), 0);
    EXPECT_EQ(std::string(info.dli_fname).find("libm"), std::string::npos)
        << name << " is from " << info.dli_fname;
  }
}

TEST(Physics, BallRollsAsFarAsConstantDecelerationSays) {
  for (const double speed : {0.05, 0.5, 1.0, 1.4}) {
    for (const double deceleration : {0.2, 0.35}) {
      const Scenario s = scene(false, 0, deceleration, 0.5);
      Physics physics(s);
      PhysicsState state;
      state.ball = {.vx_mps = speed * 0.6, .vy_mps = speed * 0.8};
      const double h = 0.002;
      const auto substeps = static_cast<int64_t>(std::ceil(speed / deceleration / h)) + 10;
      physics.advance(state, h, substeps, {});
      const double way = speed * speed / (2 * deceleration);
      EXPECT_NEAR(state.ball.x_m, 0.6 * way, 1e-4 * way + 1e-6) << speed << " " << deceleration;
      EXPECT_NEAR(state.ball.y_m, 0.8 * way, 1e-4 * way + 1e-6);
      EXPECT_EQ(state.ball.vx_mps, 0);
    }
  }
}

TEST(Physics, BallBouncesOffAWallByTheLawOfReflectionWithRestitution) {
  for (const double angle : {0.0, 0.4, 1.1}) {
    for (const double restitution : {0.0, 0.5, 1.0}) {
      const Scenario s = scene(true, 0, 0, restitution);
      Physics physics(s);
      PhysicsState state;
      const double speed = 1.2;
      state.ball = {.x_m = 0.2,
                    .y_m = 1.0,
                    .vx_mps = speed * std::sin(angle),
                    .vy_mps = speed * std::cos(angle)};
      // The wall's foot is at y = 1.35, the ball's radius 0.042.
      const double until_hit = (1.35 - 0.042 - 1.0) / state.ball.vy_mps;
      double highest = 0;
      const Physics::Hooks hooks = {.after = [&](int64_t, const PhysicsState& now) {
        highest = std::max(highest, now.ball.y_m);
      }};
      physics.advance(state, 0.002, static_cast<int64_t>(until_hit / 0.002) + 50, hooks);
      EXPECT_NEAR(state.ball.vx_mps, speed * std::sin(angle), 1e-5);
      EXPECT_NEAR(state.ball.vy_mps, -restitution * speed * std::cos(angle), 1e-5)
          << angle << " " << restitution;
      EXPECT_NEAR(highest, 1.308, speed * 0.002);  // At the wall: within a substep's way.
      EXPECT_LT(highest, 1.308 + 0.0005);          // Sinks in by Box2D's slop at most.
    }
  }
}

TEST(Physics, TwoBodyHitKeepsMomentumAndRestitution) {
  const Scenario s = scene(false, 1, 0, 0.7);
  Physics physics(s);
  PhysicsState state;
  state.robots.resize(1);
  const double front = s.robots[0].body.footprint_x_m + 0.5 * s.robots[0].body.footprint_length_m;
  state.ball = {.x_m = front + 0.1, .vx_mps = -1.5};
  physics.advance(state, 0.002, 200, {});
  const double m = s.ball.mass_kg, M = s.robots[0].body.mass_kg;
  EXPECT_NEAR(m * state.ball.vx_mps + M * state.robots[0].vx_mps, m * -1.5, 1e-6);
  EXPECT_NEAR(state.ball.vx_mps - state.robots[0].vx_mps, 0.7 * 1.5, 1e-5);
  EXPECT_NEAR(state.robots[0].omega_radps, 0, 1e-6);
}

TEST(Physics, ObliqueBounceOffACornerKeepsWhatRunsAlongTheWall) {
  // The wall across the corner at (+, +) runs at 45 degrees; n = (1, 1) / sqrt(2) points into it.
  for (const double restitution : {0.3, 0.8}) {
    for (const double direction : {0.1, M_PI / 4, 1.3}) {
      const Scenario s = scene(true, 0, 0, restitution);
      Physics physics(s);
      PhysicsState state;
      const double c = s.field.corner_m, speed = 1.1;
      // A place in the field from which the ball meets the middle of that wall.
      const double hit_x = s.field.half_length_m - 0.5 * c - 0.042 * M_SQRT1_2;
      const double hit_y = s.field.half_width_m - 0.5 * c - 0.042 * M_SQRT1_2;
      const double vx = speed * std::cos(direction), vy = speed * std::sin(direction);
      state.ball = {.x_m = hit_x - 0.3 * vx, .y_m = hit_y - 0.3 * vy, .vx_mps = vx, .vy_mps = vy};
      physics.advance(state, 0.002, 160, {});
      const double into = (vx + vy) * M_SQRT1_2, along = (vx - vy) * M_SQRT1_2;
      EXPECT_NEAR((state.ball.vx_mps + state.ball.vy_mps) * M_SQRT1_2, -restitution * into, 1e-5)
          << direction;
      EXPECT_NEAR((state.ball.vx_mps - state.ball.vy_mps) * M_SQRT1_2, along, 1e-5) << direction;
    }
  }
}

TEST(Physics, ALimbThatMovesGivesARestingBallItsSpeedAndTheBounce) {
  // Against a body that nothing stops, v = (1 + e) w along the line of centres.
  for (const double restitution : {0.0, 0.5}) {
    for (const double offset_m : {0.0, 0.02}) {
      const Scenario s = scene(false, 0, 0, restitution);
      Physics physics(s);
      PhysicsState state;
      const double w = 1.2, radius = 0.014, reach = radius + 0.042;
      state.limbs = {
          {.robot = 0, .x_m = -0.1, .y_m = offset_m, .vx_mps = w, .vy_mps = 0, .radius_m = radius}};
      physics.advance(state, 0.002, 60, {});
      const double sine = -offset_m / reach, cosine = std::sqrt(1 - sine * sine);
      const double speed = (1 + restitution) * w * cosine;
      // The step in which they touch ends with the limb up to 2.4 mm too far: the line of centres
      // is that uncertain.
      const double turned = offset_m == 0 ? 1e-6 : 0.0024 / reach;
      EXPECT_NEAR(state.ball.vx_mps, speed * cosine, 2 * w * turned)
          << restitution << " " << offset_m;
      EXPECT_NEAR(state.ball.vy_mps, speed * sine, 2 * w * turned)
          << restitution << " " << offset_m;
    }
  }
}

TEST(Physics, HitsOfRandomBodiesKeepMomentumAndSpin) {
  const RandomStream draw{13, 0};
  for (uint64_t trial = 0; trial < 100; ++trial) {
    const RandomStream t = draw.child(trial);
    const Scenario s = scene(false, 6, 0, uniform(t, 0));
    Physics physics(s);
    PhysicsState state;
    for (size_t i = 0; i < 6; ++i) {
      // Towards the middle, so that they meet.
      const double angle = 1.0472 * static_cast<double>(i) + 0.4 * uniform(t, 10 + i),
                   speed = 0.5 + uniform(t, 20 + i);
      state.robots.push_back({0.8 * std::cos(angle), 0.8 * std::sin(angle),
                              6.28 * uniform(t, 30 + i), -speed * std::cos(angle),
                              -speed * std::sin(angle), 4 * uniform(t, 40 + i) - 2});
    }
    state.ball = {.vx_mps = 2 * uniform(t, 1) - 1, .vy_mps = 2 * uniform(t, 2) - 1};
    const Momentum before = momentum(s, state);
    physics.advance(state, 0.002, 500, {});
    const Momentum after = momentum(s, state);
    EXPECT_GT(std::abs(state.robots[0].vx_mps) + std::abs(state.robots[0].omega_radps), 0);
    EXPECT_NEAR(after.x_ns, before.x_ns, 1e-5) << trial;
    EXPECT_NEAR(after.y_ns, before.y_ns, 1e-5) << trial;
    // Bodies that sank into each other are put apart without a change of their velocities, which
    // moves their lever.
    EXPECT_NEAR(after.spin_nms, before.spin_nms, 2e-3) << trial;
  }
}

TEST(Physics, FastBallsNeverPassThroughWallsOrRobots) {
  const RandomStream draw{7, 0};
  for (uint64_t trial = 0; trial < 200; ++trial) {
    const Scenario s = scene(true, 4, 0.2, 0.5);
    Physics physics(s);
    PhysicsState state;
    const RandomStream t = draw.child(trial);
    for (size_t i = 0; i < 4; ++i) {
      state.robots.push_back({-1.5 + static_cast<double>(i), 1.6 * uniform(t, 10 + i) - 0.8,
                              6.28 * uniform(t, 20 + i)});
    }
    const double direction = 6.2832 * uniform(t, 0), speed = 5 + 15 * uniform(t, 1);
    state.ball = {.x_m = 0,
                  .y_m = 1.1,
                  .vx_mps = speed * std::cos(direction),
                  .vy_mps = speed * std::sin(direction)};
    const Physics::Hooks hooks = {.after = [&](int64_t, const PhysicsState& now) {
      const double x = std::abs(now.ball.x_m), y = std::abs(now.ball.y_m);
      const double slack = 0.0005;
      const bool in_field = x <= 2.1 - 0.042 + slack && y <= 1.35 - 0.042 + slack;
      const bool in_goal = y <= 0.3 - 0.042 + slack && x <= 2.4 - 0.042 + slack;
      const bool between_posts = y <= 0.3 && x <= 2.1;
      ASSERT_TRUE(in_field || in_goal || between_posts)
          << trial << ": " << now.ball.x_m << " " << now.ball.y_m;
      ASSERT_LE(x + y, 2.1 + 1.35 - 0.3 - 0.042 * std::sqrt(2.0) + 2 * slack);
      for (const PlanarBody& robot : now.robots) {
        const double dx = now.ball.x_m - robot.x_m, dy = now.ball.y_m - robot.y_m;
        const double c = std::cos(robot.theta_rad), sn = std::sin(robot.theta_rad);
        const double forward = std::abs(c * dx + sn * dy + 0.005),
                     left = std::abs(c * dy - sn * dx);
        ASSERT_FALSE(forward < 0.11 + 0.042 - 0.012 && left < 0.077 - 0.002)
            << trial << " ball inside a robot";
      }
    }};
    physics.advance(state, 0.002, 500, hooks);
  }
}

TEST(Physics, EnergyOfUndrivenBodiesNeverGrows) {
  const RandomStream draw{11, 0};
  for (uint64_t trial = 0; trial < 100; ++trial) {
    const RandomStream t = draw.child(trial);
    const Scenario s = scene(true, 6, 0.2, uniform(t, 0));
    Physics physics(s);
    PhysicsState state;
    for (size_t i = 0; i < 6; ++i) {
      const double x = -1.5 + 0.6 * static_cast<double>(i);
      state.robots.push_back({x, 1.8 * uniform(t, 10 + i) - 0.9, 6.28 * uniform(t, 20 + i),
                              4 * uniform(t, 30 + i) - 2, 4 * uniform(t, 40 + i) - 2,
                              6 * uniform(t, 50 + i) - 3});
    }
    state.ball = {.x_m = 0.3 * uniform(t, 1),
                  .y_m = 1.2,
                  .vx_mps = 6 * uniform(t, 2) - 3,
                  .vy_mps = -3 * uniform(t, 3)};
    double before = energy(s, state);
    const Physics::Hooks hooks = {.after = [&](int64_t k, const PhysicsState& now) {
      const double after = energy(s, now);
      ASSERT_LE(after, before * (1 + 1e-5)) << "trial " << trial << " substep " << k;
      before = after;
    }};
    for (int i = 0; i < 100; ++i) physics.advance(state, 0.002, 4, hooks);
  }
}

}  // namespace
}  // namespace seam
