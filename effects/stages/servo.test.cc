#include "effects/stages/servo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::effects {
namespace {

// The definitions integrated by brute force: Euler steps of `h`, written apart from the solver.
struct BruteForce {
  ServoModel m;
  double q, v = 0, load;
  void run(double command, double seconds, double h) {
    const long steps = std::lround(seconds / h);
    for (long i = 0; i < steps; ++i) {
      const double e = command - q;
      double want = m.tau_s > 0 ? e / m.tau_s : e / h;
      if (std::abs(want) > m.rad_per_s) want = std::copysign(m.rad_per_s, e);
      if (std::isfinite(m.rad_per_s2)) {
        const double brake = std::sqrt(2 * m.rad_per_s2 * std::abs(e));
        if (std::abs(want) > brake) want = std::copysign(brake, e);
        const double change = want - v, most = m.rad_per_s2 * h;
        v += std::abs(change) > most ? std::copysign(most, change) : change;
      } else {
        v = want;
      }
      if (std::abs(e) < m.dead_band_rad) v = 0;
      q += v * h;
      const double half = 0.5 * m.backlash_rad;
      if (q - load > half) load = q - half;
      if (load - q > half) load = q + half;
    }
  }
};

TEST(Servo, AgreesWithBruteForceForRandomCombinations) {
  const RandomStream random{7, 1};
  for (int trial = 0; trial < 60; ++trial) {
    const RandomStream r = random.child(trial);
    const auto draw = [&](int i) { return uniform(r, i); };
    ServoModel m;
    if (draw(0) < 0.6) m.tau_s = 0.005 + 0.08 * draw(1);
    if (draw(2) < 0.5) m.rad_per_s = 0.5 + 5 * draw(3);
    if (draw(4) < 0.6) m.rad_per_s2 = 5 + 100 * draw(5);
    if (draw(6) < 0.3 && m.tau_s > 0) m.dead_band_rad = 0.03 * draw(7);
    if (draw(8) < 0.4) m.backlash_rad = 0.05 * draw(9);
    ServoState state = servo_at_rest(m, 0.1);
    BruteForce brute{.m = m, .q = 0.1, .load = 0.1};
    const double h = 2e-6;
    for (int step = 0; step < 25; ++step) {
      const double command = (draw(20 + step) - 0.5) * (step % 3 == 0 ? 2.0 : 0.2);
      const double seconds = 0.002 * std::floor(1 + 40 * draw(100 + step));
      advance_servo(m, command, seconds, state);
      brute.run(command, seconds, h);
      // Euler's own error is of the order of the rate or acceleration times the step.
      ASSERT_NEAR(state.motor_rad, brute.q, 2e-4)
          << trial << " " << step << " tau " << m.tau_s << " v " << m.rad_per_s << " a "
          << m.rad_per_s2 << " band " << m.dead_band_rad << " rate " << brute.v;
      ASSERT_NEAR(state.load_rad, brute.load, 2e-4) << trial << " " << step;
    }
  }
}

TEST(Servo, SplittingAnIntervalChangesNothing) {
  const RandomStream random{8, 1};
  for (int trial = 0; trial < 200; ++trial) {
    const RandomStream r = random.child(trial);
    ServoModel m;
    if (uniform(r, 0) < 0.5) m.tau_s = 0.05 * uniform(r, 1);
    if (uniform(r, 2) < 0.5) m.rad_per_s = 3 * uniform(r, 3);
    if (uniform(r, 4) < 0.7) m.rad_per_s2 = 60 * uniform(r, 5);
    ServoState whole = servo_at_rest(m, 0), split = whole;
    for (int step = 0; step < 20; ++step) {
      const double command = uniform(r, 10 + step) - 0.5;
      advance_servo(m, command, 0.05, whole);
      for (int k = 0; k < 10; ++k) advance_servo(m, command, 0.005, split);
      ASSERT_NEAR(whole.motor_rad, split.motor_rad, 1e-8) << trial << " " << step;
    }
  }
}

TEST(Servo, ClosedForms) {
  ServoModel lag{.tau_s = 0.05};
  ServoState state = servo_at_rest(lag, 0);
  advance_servo(lag, 1.0, 0.05, state);
  EXPECT_NEAR(state.motor_rad, 1 - std::exp(-1.0), 1e-15);
  // From rest to rest over a distance d at acceleration a: 2 sqrt(d / a).
  ServoModel bang{.rad_per_s2 = 10};
  state = servo_at_rest(bang, 0);
  advance_servo(bang, 0.4, std::sqrt(0.4 / 10), state);
  EXPECT_NEAR(state.motor_rad, 0.2, 1e-12);
  EXPECT_NEAR(state.motor_radps, 2.0, 1e-9);
  advance_servo(bang, 0.4, std::sqrt(0.4 / 10), state);
  EXPECT_NEAR(state.motor_rad, 0.4, 1e-9);
  // Stiction of an otherwise ideal servo: small moves are not made, large ones are made whole.
  ServoModel sticky{.dead_band_rad = 0.02};
  state = servo_at_rest(sticky, 0);
  advance_servo(sticky, 0.015, 1, state);
  EXPECT_EQ(state.motor_rad, 0);
  advance_servo(sticky, 0.025, 1, state);
  EXPECT_EQ(state.motor_rad, 0.025);
}

TEST(Servo, LatencyDelaysAndASampleShowsTheJointBeforeItsCommandActs) {
  Servo ideal(ServoModel{}, 0, 0.3);
  ideal.command(0, 1.0);
  ideal.advance_to(0);
  EXPECT_EQ(ideal.joint_rad(), 0.3);
  ideal.command(0.008, 2.0);
  ideal.advance_to(0.008);
  EXPECT_EQ(ideal.joint_rad(), 1.0);
  Servo late(ServoModel{.latency_s = 0.012}, 0, 0.3);
  for (int k = 0; k < 5; ++k) {
    late.command(0.008 * k, k);
    late.advance_to(0.008 * k);
    EXPECT_EQ(late.joint_rad(), k < 2 ? 0.3 : k - 2) << k;
  }
  // A command with the torque off does not act.
  Servo off(ServoModel{.tau_s = 0.01}, 0, 0.3);
  off.command(0, 1.0, false);
  off.advance_to(1);
  EXPECT_EQ(off.joint_rad(), 0.3);
}

TEST(Servo, SagStartsAtRestWhereTheJointIsSeen) {
  const ServoModel sag{.sag_rad = 0.1, .level_rad = 0.2};
  const ServoState state = servo_at_rest(sag, 0.5);
  EXPECT_NEAR(joint_angle(sag, state), 0.5, 1e-14);
  EXPECT_NEAR(state.motor_rad - 0.1 * std::cos(state.motor_rad - 0.2), 0.5, 1e-14);
}

}  // namespace
}  // namespace seam::effects
