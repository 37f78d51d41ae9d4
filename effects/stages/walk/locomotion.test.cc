#include "effects/stages/walk/locomotion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::effects {
namespace {

// The definitions by many small straight steps, written apart from the solver.
WalkState brute_force(const Locomotion& w, const std::vector<BodyVelocity>& commands,
                      double seconds, int steps) {
  WalkState s;
  double vx = 0, vy = 0, om = 0;
  const double h = seconds / steps;
  for (const BodyVelocity& c : commands) {
    for (int i = 0; i < steps; ++i) {
      const double gain = w.tau_s > 0 ? 1 - std::exp(-h / w.tau_s) : 1;
      const double before_x = vx, before_y = vy, before_o = om;
      vx += (c.vx_mps - vx) * gain, vy += (c.vy_mps - vy) * gain, om += (c.omega_radps - om) * gain;
      const double mx = w.tau_s > 0 ? (vx + before_x) / 2 : vx,
                   my = w.tau_s > 0 ? (vy + before_y) / 2 : vy;
      const double mo = w.tau_s > 0 ? (om + before_o) / 2 : om;
      const double fx = mx * (1 + w.vx_scale), fy = my * (1 + w.vy_scale),
                   path = std::hypot(fx, fy) * h;
      const double turn = mo * (1 + w.omega_scale) * h + w.left_excess * std::max(mo, 0.0) * h +
                          w.heading_rad_per_m * path;
      const double mid = s.theta_rad + turn / 2;
      s.x_m += (std::cos(mid) * fx - std::sin(mid) * fy) * h;
      s.y_m += (std::sin(mid) * fx + std::cos(mid) * fy) * h;
      s.theta_rad += turn, s.path_m += path;
    }
  }
  return s;
}

TEST(Locomotion, AgreesWithSmallSteps) {
  const std::vector<BodyVelocity> commands = {
      {0.2, 0, 0.5}, {0.1, -0.15, -2}, {0, 0, 1}, {0.3, 0.05, 1e-7}, {0, 0, 0}};
  for (double tau : {0.0, 0.004, 0.15, 2.0}) {
    for (double drift : {0.0, 0.3, -0.2}) {
      const Locomotion w{.vx_scale = -0.1,
                         .vy_scale = 0.2,
                         .omega_scale = 0.05,
                         .heading_rad_per_m = drift,
                         .left_excess = drift < 0 ? 0.3 : 0,
                         .tau_s = tau};
      WalkState s;
      for (const BodyVelocity& c : commands) advance_walk(w, c, 0.4, s);
      const WalkState b = brute_force(w, commands, 0.4, 40000);
      // The speed has a kink where the body turns back, which costs the steps some digits.
      EXPECT_NEAR(s.x_m, b.x_m, 1e-5) << tau;
      EXPECT_NEAR(s.y_m, b.y_m, 1e-5) << tau;
      EXPECT_NEAR(s.theta_rad, b.theta_rad, 1e-5) << tau;
      EXPECT_NEAR(s.path_m, b.path_m, 1e-5) << tau;
    }
  }
}

// The point's own velocity, (vx - y omega, vy + x omega) in the body's axes, by small steps.
TEST(Locomotion, APointBesideTheAxleMovesByItsOwnVelocity) {
  const Tracker tracker{.x_m = 0.08, .y_m = -0.3};
  WalkState s;
  double x = 0, y = 0, theta = 0;
  for (const BodyVelocity& c : {BodyVelocity{0.2, 0.1, 0.9}, {0, 0, -2}, {-0.3, 0, 0.1}}) {
    advance_walk({}, c, 0.7, s);
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double h = 0.7 / kSteps, mid = theta + c.omega_radps * h / 2;
      const double along = c.vx_mps + 0.3 * c.omega_radps, across = c.vy_mps + 0.08 * c.omega_radps;
      x += (std::cos(mid) * along - std::sin(mid) * across) * h;
      y += (std::sin(mid) * along + std::cos(mid) * across) * h;
      theta += c.omega_radps * h;
    }
    EXPECT_NEAR(tracker.seen(s).x_m, x, 1e-8);
    EXPECT_NEAR(tracker.seen(s).y_m, y, 1e-8);
    EXPECT_NEAR(tracker.seen(s).theta_rad, theta, 1e-10);
  }
}

TEST(Locomotion, AQuarterCircleIsExact) {
  WalkState s;
  advance_walk({}, {1.0, 0, std::acos(-1.0) / 2}, 1.0, s);
  EXPECT_NEAR(s.x_m, 2 / std::acos(-1.0), 1e-15);
  EXPECT_NEAR(s.y_m, 2 / std::acos(-1.0), 1e-15);
}

// A body on wheels whose velocity is commanded: each wheel by small steps, apart from the solver.
TEST(Locomotion, WheelsCarryOutWhatTheyAreTold) {
  const Locomotion walk{.wheels = {.driven = true,
                                   .metres_per_tick = 1e-4,
                                   .base_m = 0.3,
                                   .left_scale = 0.02,
                                   .right_scale = -0.05,
                                   .base_scale = 0.1,
                                   .slip_s = 0.15}};
  WalkState state;
  double x = 0, y = 0, theta = 0;
  for (const BodyVelocity& commanded : {BodyVelocity{0.4, 0.2, 0.8}, BodyVelocity{-0.1, 0, -2}}) {
    advance_walk(walk, commanded, 0.7, state);
    const double left = (commanded.vx_mps - 0.15 * commanded.omega_radps) * 1.02,
                 right = (commanded.vx_mps + 0.15 * commanded.omega_radps) * 0.95;
    const double omega = (right - left) / 0.33;
    const double v = 0.5 * (left + right) * (1 - 0.15 * std::abs(omega));
    const int steps = 20000;
    const double h = 0.7 / steps;
    for (int i = 0; i < steps; ++i) {
      x += v * h * std::cos(theta + omega * h / 2);
      y += v * h * std::sin(theta + omega * h / 2);
      theta += omega * h;
    }
  }
  EXPECT_NEAR(state.x_m, x, 1e-8);
  EXPECT_NEAR(state.y_m, y, 1e-8);
  EXPECT_NEAR(state.theta_rad, theta, 1e-10);
}

}  // namespace
}  // namespace seam::effects
