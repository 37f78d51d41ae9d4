// Motors against closed forms, energies, and a brute-force integration written apart.
#include "effects/stages/torque/torque.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "sim_core/base/random.h"

namespace seam::effects {
namespace {

void run(const TorqueModel& motor, const MotorInput& input, double seconds, MotorState& state) {
  MotorInput in = input;
  for (double done = 0; done < seconds;) {
    in.command_rad = input.command_rad + input.command_radps * done;
    done += advance_motor(motor, in, seconds - done, state);
  }
}

TorqueModel motor(double stall, double back_emf, double gain) {
  TorqueModel m{.present = true};
  m.stall_rad_per_s2 = stall, m.back_emf_per_s = back_emf, m.gain = gain;
  return m;
}

// A pendulum that hangs down at angle 0.
TorqueModel pendulum(double rad_per_s2) {
  TorqueModel m{.present = true};
  m.gravity_rad_per_s2 = rad_per_s2, m.level_rad = std::numbers::pi / 2;
  return m;
}

const MotorInput kFree{.enabled = false};

// The complete elliptic integral of the first kind by the arithmetic-geometric mean.
double elliptic(double k) {
  double a = 1, b = std::sqrt(1 - k * k);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b), a = mean;
  }
  return std::numbers::pi / (2 * a);
}

TEST(Motor, APendulumHasThePeriodOfItsAmplitude) {
  constexpr double kGravity = 98.1;
  for (const double amplitude : {1e-4, 0.5, 1.5, 3.0}) {
    const double period = 4 * elliptic(std::sin(amplitude / 2)) / std::sqrt(kGravity);
    MotorState state{.q_rad = amplitude};
    run(pendulum(kGravity), kFree, period, state);
    EXPECT_NEAR(state.q_rad, amplitude, 1e-9 * std::max(1.0, amplitude)) << amplitude;
    run(pendulum(kGravity), kFree, period / 2, state);
    EXPECT_NEAR(state.q_rad, -amplitude, 1e-8) << amplitude;
    run(pendulum(kGravity), kFree, period / 4, state);
    EXPECT_NEAR(state.q_rad, 0, 1e-8) << amplitude;
  }
  EXPECT_NEAR(4 * elliptic(0) / std::sqrt(kGravity), 2 * std::numbers::pi / std::sqrt(kGravity),
              1e-12);
}

TEST(Motor, APendulumKeepsItsEnergy) {
  const TorqueModel m = pendulum(80);
  MotorState state{.q_rad = 0.3, .w_radps = 25};  // Enough to turn over.
  const auto energy = [&] {
    return 0.5 * state.w_radps * state.w_radps - 80 * std::cos(state.q_rad);
  };
  const double before = energy();
  for (int row = 0; row < 2000; ++row) run(m, kFree, 0.005, state);
  EXPECT_GT(state.q_rad, 50);
  EXPECT_NEAR(energy(), before, 1e-5);
}

// Level: gravity is constant to first order; the back-EMF of a driven motor at duty 0 brakes it.
// A wave of torque is a pendulum whose angle is so many times the joint's.
TEST(Motor, CoggingSwingsAboutATooth) {
  TorqueModel m{.present = true};
  m.cogging_rad_per_s2 = 30, m.cogging_per_turn = 12, m.cogging_rad = std::numbers::pi;
  for (const double amplitude : {0.5, 3.0}) {
    const double period = 4 * elliptic(std::sin(amplitude / 2)) / std::sqrt(30.0 * 12);
    MotorState state{.q_rad = amplitude / 12};
    run(m, kFree, period, state);
    EXPECT_NEAR(state.q_rad, amplitude / 12, 1e-9) << amplitude;
    run(m, kFree, period / 2, state);
    EXPECT_NEAR(state.q_rad, -amplitude / 12, 1e-8) << amplitude;
  }
}

TEST(Motor, AFallAgainstBackEmfApproachesItsFinalRate) {
  TorqueModel m = motor(0, 12, 1);
  m.gravity_rad_per_s2 = 30;
  // So short a way that the pull is constant.
  MotorState state;
  const double t = 1e-5;
  run(m, {}, t, state);
  EXPECT_NEAR(state.w_radps, -30 / 12.0 * (1 - std::exp(-12 * t)), 1e-12);
  // A constant drive in its place: w = s / b (1 - exp(-b t)), for as long as one likes.
  TorqueModel driven = motor(240, 12, 1e4);
  MotorState fast;
  run(driven, {.command_rad = 1e3}, 0.4, fast);
  EXPECT_NEAR(fast.w_radps, 20 * (1 - std::exp(-12 * 0.4)), 1e-9);
  EXPECT_NEAR(fast.q_rad, 20 * (0.4 - (1 - std::exp(-12 * 0.4)) / 12), 1e-9);
  // Without torque neither drive nor back-EMF.
  run(driven, kFree, 0.3, fast);
  EXPECT_NEAR(fast.w_radps, 20 * (1 - std::exp(-12 * 0.4)), 1e-9);
}

TEST(Motor, CoulombFrictionStopsAfterTheTimeAndTheWayOfConstantBraking) {
  TorqueModel m{.present = true};
  m.coulomb_rad_per_s2 = 7;
  for (const double start : {3.0, -3.0}) {
    MotorState state{.w_radps = start};
    run(m, kFree, 3.0 / 7 - 1e-6, state);
    EXPECT_NEAR(state.w_radps, std::copysign(7e-6, start), 1e-12);
    run(m, kFree, 1, state);
    EXPECT_EQ(state.w_radps, 0);
    EXPECT_NEAR(state.q_rad, std::copysign(9.0 / 14, start), 1e-12);
    const double rest = state.q_rad;
    run(m, kFree, 100, state);
    EXPECT_EQ(state.q_rad, rest);
  }
}

TEST(Motor, EachSwingAgainstDryFrictionLosesTheSameAngle) {
  // A spring of 100 about the command, friction of 5: each half swing ends 2 * 5 / 100 nearer.
  TorqueModel m = motor(1000, 0, 0.1);
  m.coulomb_rad_per_s2 = 5;
  MotorState state{.q_rad = 0.53};
  const double half = std::numbers::pi / 10;
  for (int swing = 1; swing <= 5; ++swing) {
    run(m, {}, half, state);
    EXPECT_NEAR(std::abs(state.q_rad), 0.53 - 0.1 * swing, 1e-10);
    EXPECT_NEAR(state.w_radps, 0, 1e-10);
  }
  const double rest = state.q_rad;  // 0.03: friction holds up to 0.05.
  run(m, {}, 10, state);
  EXPECT_NEAR(state.q_rad, rest, 1e-12);
  EXPECT_EQ(state.w_radps, 0);
}

// A P-controller with back-EMF ends at its command; with gravity beside it; with dry friction
// within what that holds, and no controller of proportion alone keeps swinging.
TEST(Motor, AProportionalControllerHasNoLimitCycle) {
  TorqueModel m = motor(400, 3, 2);
  m.load_fraction = 0.2, m.stribeck_rad_per_s2 = 6, m.stribeck_rad_per_s = 0.2;
  m.coulomb_rad_per_s2 = 2, m.gravity_rad_per_s2 = 60;
  MotorState state;
  run(m, {.command_rad = 0.7}, 20, state);
  EXPECT_EQ(state.w_radps, 0);
  const double net = 800 * (0.7 - state.q_rad) - 60 * std::cos(state.q_rad);
  EXPECT_LE(std::abs(net), 8 / (1 - 0.2));
  const double rest = state.q_rad;
  run(m, {.command_rad = 0.7}, 100, state);
  EXPECT_EQ(state.q_rad, rest);
}

TEST(Motor, AnExponentialApproachWithoutInertiasShare) {
  // Overdamped: both exponentials of w'' + 60 w' + 500 w = 0, at 10 and 50 a second.
  const TorqueModel m = motor(1000, 60, 0.5);
  MotorState state;
  run(m, {.command_rad = 1}, 0.13, state);
  EXPECT_NEAR(state.q_rad, 1 - (50 * std::exp(-1.3) - 10 * std::exp(-6.5)) / 40, 1e-10);
}

TEST(Motor, ARestingJointBreaksAwayWhenItsCommandHasMovedFarEnough) {
  TorqueModel m = motor(100, 10, 1);
  m.coulomb_rad_per_s2 = 20, m.load_fraction = 0.2;
  // Held until 100 * way = 20 / 0.8.
  MotorState state;
  const MotorInput ramp{.command_radps = 0.5};
  run(m, ramp, 0.499, state);
  EXPECT_EQ(state.q_rad, 0);
  run(m, {.command_rad = 0.5 * 0.499, .command_radps = 0.5}, 0.021, state);
  EXPECT_GT(state.q_rad, 0);
  EXPECT_LT(state.q_rad, 1e-4);
}

TEST(Motor, GearsHoldWhatTheyCarry) {
  // Held at drive = load = 40: the gears carry 80, of which 0.25 hold. The command lowers the drive
  // by d: they carry 80 - d, and d is left to move the joint; it falls from d = 16 on.
  TorqueModel m = motor(100, 10, 1);
  m.gravity_rad_per_s2 = 40, m.carried_fraction = 0.25;
  MotorState state;
  const MotorInput down{.command_rad = 0.4, .command_radps = -0.5};
  run(m, down, 0.319, state);
  EXPECT_EQ(state.q_rad, 0);
  run(m, {.command_rad = 0.4 - 0.5 * 0.319, .command_radps = -0.5}, 0.02, state);
  EXPECT_LT(state.q_rad, 0);
  EXPECT_GT(state.q_rad, -1e-4);
  // Raised, they carry 80 + d: it climbs from 0.75 d = 20 on.
  state = {};
  run(m, {.command_rad = 0.4, .command_radps = 0.5}, 0.533, state);
  EXPECT_EQ(state.q_rad, 0);
  run(m, {.command_rad = 0.4 + 0.5 * 0.533, .command_radps = 0.5}, 0.02, state);
  EXPECT_GT(state.q_rad, 0);
}

// The same equation in tiny steps; at rest by the definition of dry friction.
struct BruteForce {
  TorqueModel m;
  double q, w = 0;
  void run(const MotorInput& in, double seconds) {
    const long steps = std::lround(seconds / 2e-6);
    const double h = seconds / static_cast<double>(steps);
    for (long i = 0; i < steps; ++i) step(in, h);
  }
  void step(const MotorInput& in, double h) {
    double duty = m.gain * in.kp * (in.command_rad - q) - m.damping_s * w;
    duty = std::min(std::max(duty, -m.max_duty), m.max_duty);
    double drive = in.enabled ? m.stall_rad_per_s2 * duty * in.voltage - m.back_emf_per_s * w : 0;
    drive = std::min(std::max(drive, -m.limit_rad_per_s2), m.limit_rad_per_s2);
    const double load = m.gravity_rad_per_s2 * std::cos(q - m.level_rad) -
                        m.cogging_rad_per_s2 * std::sin(m.cogging_per_turn * q + m.cogging_rad);
    const double net = drive - load, gear = drive + load;
    const double dry = m.coulomb_rad_per_s2 + m.load_fraction * std::abs(net) +
                       m.carried_fraction * std::abs(gear) +
                       m.stribeck_rad_per_s2 * std::exp(-std::abs(w) / m.stribeck_rad_per_s);
    double next = w + h * (net - m.viscous_per_s * w);
    if (std::abs(next) <= h * dry && std::abs(w) <= h * (dry + std::abs(net)))
      next = 0;
    else
      next -= h * std::copysign(dry, w != 0 ? w : net);
    if (w * next < 0) next = 0;
    q += 0.5 * h * (w + next);
    w = next;
  }
};

TEST(Motor, AgreesWithBruteForceForRandomCombinations) {
  const RandomStream random{11, 1};
  int rests = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const RandomStream r = random.child(trial);
    const auto draw = [&](int i) { return uniform(r, i); };
    TorqueModel m = motor(50 + 400 * draw(0), 30 * draw(1), 0.5 + 4 * draw(2));
    if (draw(3) < 0.3) m.damping_s = 0.1 * draw(4);
    if (draw(5) < 0.3) m.max_duty = 0.3 + 0.7 * draw(6);
    if (draw(7) < 0.6) m.gravity_rad_per_s2 = 100 * draw(8), m.level_rad = 3 * draw(9);
    if (draw(10) < 0.4) m.viscous_per_s = 5 * draw(11);
    if (draw(12) < 0.5) m.coulomb_rad_per_s2 = 15 * draw(13);
    m.stribeck_rad_per_s = 0.05 + draw(14);
    if (draw(15) < 0.4) m.stribeck_rad_per_s2 = 15 * draw(16);
    if (draw(17) < 0.5) m.load_fraction = 0.4 * draw(18);
    if (draw(21) < 0.5) m.carried_fraction = 0.4 * draw(22);
    if (draw(23) < 0.4)
      m.cogging_rad_per_s2 = 40 * draw(24), m.cogging_per_turn = 30 * draw(25),
      m.cogging_rad = 6 * draw(26);
    if (draw(19) < 0.3) m.limit_rad_per_s2 = 30 + 200 * draw(20);
    MotorState state{.q_rad = 0.1};
    BruteForce brute{.m = m, .q = 0.1};
    for (int step = 0; step < 20; ++step) {
      const MotorInput in{.command_rad = (draw(30 + step) - 0.5) * (step % 3 == 0 ? 3.0 : 0.3),
                          .kp = 0.5 + draw(60 + step),
                          .voltage = 0.8 + 0.4 * draw(90 + step),
                          .enabled = draw(120 + step) < 0.85};
      const double seconds = 0.002 * std::floor(1 + 60 * draw(150 + step));
      run(m, in, seconds, state);
      brute.run(in, seconds);
      rests += state.w_radps == 0;
      ASSERT_NEAR(state.q_rad, brute.q, 1e-3) << trial << " " << step;
      // Apart by Euler's own error, which must not add up here.
      brute.q = state.q_rad, brute.w = state.w_radps;
    }
  }
  EXPECT_GT(rests, 20);
}

TEST(Motor, StepsDoNotMatter) {
  TorqueModel m = motor(300, 15, 3);
  m.gravity_rad_per_s2 = 70, m.level_rad = 1, m.coulomb_rad_per_s2 = 5, m.load_fraction = 0.2;
  m.stribeck_rad_per_s2 = 5, m.stribeck_rad_per_s = 0.1, m.limit_rad_per_s2 = 200;
  m.carried_fraction = 0.15;
  MotorState whole, rows, fine;
  for (int block = 0; block < 40; ++block) {
    const MotorInput in{.command_rad = block % 2 == 0 ? 1.0 : -0.4, .enabled = block % 7 != 5};
    run(m, in, 0.15, whole);
    for (int row = 0; row < 30; ++row) run(m, in, 0.005, rows);
    for (int row = 0; row < 1500; ++row) run(m, in, 0.0001, fine);
    ASSERT_NEAR(whole.q_rad, fine.q_rad, 1e-7) << block;
    ASSERT_NEAR(rows.q_rad, fine.q_rad, 1e-7) << block;
  }
}

TEST(Motor, FrictionNeverAddsEnergy) {
  TorqueModel m = pendulum(90);
  m.coulomb_rad_per_s2 = 3, m.stribeck_rad_per_s2 = 4, m.stribeck_rad_per_s = 0.3;
  m.load_fraction = 0.15, m.carried_fraction = 0.1, m.viscous_per_s = 0.2;
  MotorState state{.q_rad = 2.8};
  const auto energy = [&] {
    return 0.5 * state.w_radps * state.w_radps - 90 * std::cos(state.q_rad);
  };
  double before = energy();
  for (int row = 0; row < 3000; ++row) {
    run(m, kFree, 0.003, state);
    ASSERT_LE(energy(), before + 1e-9) << row;
    before = energy();
  }
  EXPECT_EQ(state.w_radps, 0);
  EXPECT_LE(90 * std::abs(std::sin(state.q_rad)), 7 / (1 - 0.15 - 0.1));
}

}  // namespace
}  // namespace seam::effects
