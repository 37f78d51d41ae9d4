#include "effects/stages/walk/fading_velocity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::effects {
namespace {

// The definition by many small arcs, at the middle of each; errors fall as the square of the step.
Place by_small_arcs(const FadingVelocity& v, double dt_s, int steps) {
  Place place;
  const double h = dt_s / steps;
  for (int i = 0; i < steps; ++i) {
    const double share = std::exp(-(i + 0.5) * h / v.tau_s);
    const auto mix = [&](double to, double from) { return to + (from - to) * share; };
    const double vx = mix(v.to.vx_mps, v.from.vx_mps), vy = mix(v.to.vy_mps, v.from.vy_mps);
    const double speed = std::hypot(vx, vy);
    const double turn =
        h * (mix(v.to.omega_radps, v.from.omega_radps) + v.heading_rad_per_m * speed);
    const double middle = place.theta_rad + turn / 2;
    place.x_m += h * (std::cos(middle) * vx - std::sin(middle) * vy);
    place.y_m += h * (std::sin(middle) * vx + std::cos(middle) * vy);
    place.theta_rad += turn;
    place.path_m += h * speed;
  }
  return place;
}

TEST(FadingVelocity, IsTheSumOfManySmallArcs) {
  const BodyVelocity velocities[] = {
      {0, 0, 0}, {0.2, 0, 0.5}, {0.1, -0.15, -2}, {-0.3, 0.05, 1e-7}, {0.25, 0.2, 40}};
  for (const double tau_s : {0.01, 0.15, 2.0}) {
    for (const double drift : {0.0, 0.3}) {
      for (const BodyVelocity& from : velocities) {
        for (const BodyVelocity& to : velocities) {
          const FadingVelocity v{from, to, tau_s, drift};
          const Place exact = by_small_arcs(v, 0.4, 100'000);
          Place place;
          move_along(v, 0.4, place);
          const double bound = drift == 0 ? 1e-6 : 1e-5;
          EXPECT_NEAR(place.x_m, exact.x_m, bound);
          EXPECT_NEAR(place.y_m, exact.y_m, bound);
          EXPECT_NEAR(place.theta_rad, exact.theta_rad, bound);
          EXPECT_NEAR(place.path_m, exact.path_m, 1e-5);
        }
      }
    }
  }
}

// Straight ahead and back again: both ways in closed form.
TEST(FadingVelocity, WalksBothWaysOfATurnBack) {
  const double tau_s = 0.15, from = 0.2, to = -0.1, seconds = 0.5;
  Place place;
  move_along({{from, 0, 0}, {to, 0, 0}, tau_s}, seconds, place);
  const auto way = [&](double t) {
    return to * t + (from - to) * tau_s * (1 - std::exp(-t / tau_s));
  };
  const double turns_s = -tau_s * std::log(-to / (from - to));
  EXPECT_NEAR(place.x_m, way(seconds), 1e-12);
  EXPECT_NEAR(place.path_m, 2 * way(turns_s) - way(seconds), 1e-10);
  EXPECT_EQ(place.y_m, 0);
}

// Steps that go on where the last one ended lead where one does.
TEST(FadingVelocity, PartsMakeTheWhole) {
  const FadingVelocity whole{{0.2, -0.1, 1}, {-0.1, 0.05, -3}, 0.15, 0.2};
  Place at_once, in_parts;
  move_along(whole, 0.6, at_once);
  FadingVelocity part = whole;
  for (int i = 0; i < 75; ++i) {
    move_along(part, 0.008, in_parts);
    const double share = std::exp(-0.008 * (i + 1) / whole.tau_s);
    const auto mix = [&](double to, double from) { return to + (from - to) * share; };
    part.from = {mix(-0.1, 0.2), mix(0.05, -0.1), mix(-3, 1)};
  }
  EXPECT_NEAR(at_once.x_m, in_parts.x_m, 1e-7);
  EXPECT_NEAR(at_once.y_m, in_parts.y_m, 1e-7);
  EXPECT_NEAR(at_once.theta_rad, in_parts.theta_rad, 1e-7);
  EXPECT_NEAR(at_once.path_m, in_parts.path_m, 1e-7);
}

}  // namespace
}  // namespace seam::effects
