#include "effects/stages/locomotion.h"

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
      const double turn = mo * (1 + w.omega_scale) * h + w.heading_rad_per_m * path;
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
    for (double drift : {0.0, 0.3}) {
      const Locomotion w{.vx_scale = -0.1,
                         .vy_scale = 0.2,
                         .omega_scale = 0.05,
                         .heading_rad_per_m = drift,
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

TEST(Locomotion, AQuarterCircleIsExact) {
  WalkState s;
  advance_walk({}, {1.0, 0, std::acos(-1.0) / 2}, 1.0, s);
  EXPECT_NEAR(s.x_m, 2 / std::acos(-1.0), 1e-15);
  EXPECT_NEAR(s.y_m, 2 / std::acos(-1.0), 1e-15);
}

}  // namespace
}  // namespace seam::effects
