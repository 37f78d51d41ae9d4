// Logs of servos with torque: columns that act, starts, bad rows, and fits of whole runs.
#include <gtest/gtest.h>

#include <cmath>

#include "effects/registry.h"
#include "measurement/fitting/assess.h"
#include "measurement/kinds/joints/joints_testing.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

std::string message_of(const std::function<void()>& run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

JointLogs logs_of(const std::string& columns, const std::string& rows) {
  return read_joint_logs(
      CsvTable::from_text("run,time_s,joint,command_rad,measured_rad" + columns + "\n" + rows,
                          "joints.csv"),
      "run", true);
}

const char* const kMotor =
    "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.5}\n";

TEST(MotorLogs, GainSupplyAndReleaseComeFromTheColumns) {
  const JointLogs plain = logs_of("", "0,0,arm,1,0\n0,0.1,arm,1,0\n0,0.2,arm,1,0\n");
  const auto angles_of = [](const JointLogs& set) {
    return predict_joint_log(model_of(kMotor), set, set.logs[0], 0);
  };
  const auto angles = angles_of(plain);
  const auto column = [&](const char* name, const char* rows) {
    return angles_of(logs_of(name, rows));
  };
  EXPECT_EQ(column(",kp", "0,0,arm,1,0,1\n0,0.1,arm,1,0,1\n0,0.2,arm,1,0,1\n"), angles);
  const auto stiff = column(",kp", "0,0,arm,1,0,4\n0,0.1,arm,1,0,4\n0,0.2,arm,1,0,4\n");
  const auto twice = predict_joint_log(
      model_of("  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 2}\n"), plain,
      plain.logs[0], 0);
  EXPECT_EQ(stiff, twice);
  // Over the median, so that a steady supply of any size is 1.
  EXPECT_EQ(column(",voltage_v", "0,0,arm,1,0,7.4\n0,0.1,arm,1,0,7.4\n0,0.2,arm,1,0,7.4\n"),
            angles);
  EXPECT_LT(column(",voltage_v", "0,0,arm,1,0,5\n0,0.1,arm,1,0,7.4\n0,0.2,arm,1,0,8\n")[1],
            angles[1]);
  // Without drive it coasts.
  const auto free = column(",torque_enable", "0,0,arm,1,0,1\n0,0.1,arm,1,0,0\n0,0.2,arm,1,0,0\n");
  EXPECT_EQ(free[1], angles[1]);
  const double rate = [] {
    // q = 1 - exp(-5 t) (cos + 5 / W sin), W = sqrt(75).
    const double w = std::sqrt(75.0);
    return std::exp(-0.5) * (w + 25 / w) * std::sin(w * 0.1);
  }();
  EXPECT_NEAR(free[2], free[1] + 0.1 * rate, 1e-9);
}

TEST(MotorLogs, BadRowsAreNamed) {
  const std::tuple<const char*, std::string, const char*> bad[] = {
      {",voltage_v", "7400",
       "joints.csv:3: column voltage_v: found '7400', expected a supply in volts"},
      {",torque_enable", "2",
       "joints.csv:3: column torque_enable: found '2', expected 0 (off) or 1 (on)"},
      {",kp", "-1", "joints.csv:3: column kp: found '-1', expected a gain, 0 or more"}};
  for (const auto& [column, value, expected] : bad) {
    const std::string rows = "0,0,arm,0,0,1\n0,0.1,arm,0,0," + value + "\n";
    const std::string what = message_of([&, name = column] { logs_of(name, rows); });
    EXPECT_TRUE(what.starts_with(expected)) << what;
  }
}

TEST(MotorLogs, WhatALogLacksIsSaid) {
  const auto notes = [](const std::string& columns, const std::string& rows) {
    return notes_of_joint_logs(CsvTable::from_text(
        "run,time_s,joint,command_rad,measured_rad" + columns + "\n" + rows, "joints.csv"));
  };
  const auto never =
      notes(",kp,torque_enable", "0,0,arm,0,0,4,1\n0,0.1,arm,0,0,4,1\n1,0,arm,0,0,4,1\n");
  ASSERT_EQ(never.size(), 1u);
  EXPECT_TRUE(never[0].starts_with(
      "joints.csv:2: column torque_enable is 1 in this row and in all others, expected"))
      << never[0];
  EXPECT_TRUE(notes(",kp,torque_enable", "0,0,arm,0,0,4,1\n0,0.1,arm,0,0,4,0\n").empty());
  const auto gains = notes(",P_gain", "0,0,arm,0,0,4\n0,0.1,arm,0,0,8\n");
  ASSERT_EQ(gains.size(), 1u);
  EXPECT_TRUE(gains[0].starts_with("joints.csv:1: column P_gain is not read as a gain"))
      << gains[0];
}

TEST(MotorLogs, KinematicEffectsAreRefusedBesideAMotor) {
  EXPECT_NE(message_of([] {
              model_of(std::string(kMotor) + "  servo_lag: {tau_s: 0.1}\n");
            }).find("effect 'servo_lag' has no place beside 'motor_servo'"),
            std::string::npos);
  EXPECT_NE(message_of([] {
              model_of("  ideal_servo: {}\n  load_friction: {fraction: 0.1}\n");
            }).find("effect 'load_friction' acts in a model with 'motor_servo', expected one"),
            std::string::npos);
  model_of(std::string(kMotor) +
           "  servo_latency: {latency_s: 0.01}\n  backlash: {width_rad: 0.01}");
}

// Effect names here, as elsewhere in tests, stand for what is hidden.
TEST(MotorLogs, AFitOfWholeRunsFindsWhatMadeThemWithItsErrors) {
  const std::string truth =
      "  motor_servo: {stall_rad_per_s2: 320, back_emf_per_s: 18, gain: 0.6}\n"
      "  gravity_torque: {rad_per_s2: 55, level_rad: 1.2}\n"
      "  viscous_friction: {per_s: 0.8}\n  load_friction: {fraction: 0.15}\n";
  const std::string start =
      "  motor_servo: {stall_rad_per_s2: {value: 300, free: true}, back_emf_per_s: {value: 15, "
      "free: "
      "true}, gain: {value: 0.5, free: true}}\n"
      "  gravity_torque: {rad_per_s2: {value: 50, free: true}, level_rad: {value: 1, free: true}}\n"
      "  viscous_friction: {per_s: {value: 0.3, free: true}}\n"
      "  load_friction: {fraction: {value: 0.05, free: true}}\n";
  const double expected[] = {320, 18, 0.6, 55, 1.2, 0.8, 0.15};
  const MadeSet set("motor-fit");
  double sum2 = 0;
  int count = 0;
  for (const uint64_t seed : {1, 2, 3, 4}) {
    JointsProblem problem = set.made_by(model_of(truth), seed);
    const Model given = model_of(start);
    problem.prepare(given);
    const Assessment fitted = assess(problem, given, refitted_unknowns(given));
    EXPECT_NEAR(fitted.error, 1, 0.1);
    ASSERT_EQ(fitted.fit.value.size(), std::size(expected));
    for (size_t k = 0; k < fitted.fit.value.size(); ++k) {
      const double z = (fitted.fit.value[k] - expected[k]) / fitted.fit.sigma[k];
      EXPECT_LT(std::abs(z), 4) << fitted.unknowns[k].effect << " " << fitted.unknowns[k].parameter;
      EXPECT_LT(fitted.fit.sigma[k], 0.1 * expected[k]);
      sum2 += z * z, ++count;
    }
  }
  // Chi-square of 28, correlated among a fit's parameters.
  EXPECT_GT(sum2 / count, 0.3);
  EXPECT_LT(sum2 / count, 2.2);
}

// Where the look at accelerations lets a motor with its companions begin; empty: nowhere.
std::vector<double> first_start(JointsProblem& problem) {
  const Model ideal = model_of("  ideal_servo: {}\n");
  problem.prepare(ideal);
  const auto motor = effects::find_effect("motor_servo");
  const auto starts = problem.starts_together(ideal, *motor, effects::companions_of(*motor, ideal));
  return starts.empty() ? std::vector<double>() : starts.front();
}

TEST(MotorLogs, AMotorIsFoundFromTheAccelerationsThatALogShows) {
  const Model truth = model_of(
      "  motor_servo: {stall_rad_per_s2: 150, back_emf_per_s: 9, gain: 0.3}\n"
      "  gravity_torque: {rad_per_s2: 40, level_rad: 0.3}\n");
  JointsProblem problem = MadeSet("motor-starts").made_by(truth, 3);
  const std::vector<double> best = first_start(problem);
  ASSERT_FALSE(best.empty());
  ASSERT_EQ(best.size(), 7u);  // Its own five, gravity's two.
  EXPECT_NEAR(best[0] * best[2], 45, 5);
  EXPECT_NEAR(best[1], 9, 2);
  EXPECT_NEAR(best[5], 40, 5);
  EXPECT_NEAR(best[6], 0.3, 0.15);
}

// Over whole runs a spring a third too soft is in another phase after a few swings: the fit of
// whole runs alone stays there.
TEST(MotorLogs, ASwingInAnotherPhaseIsFoundFromShortStretches) {
  const Model truth = model_of(
      "  motor_servo: {stall_rad_per_s2: 4000, back_emf_per_s: 1.5, gain: 0.05}\n"
      "  gravity_torque: {rad_per_s2: 30, level_rad: 0.4}\n");
  const JointsProblem problem = MadeSet("motor-phase").made_by(truth, 9);
  const Model start = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 2600, free: true}, back_emf_per_s: {value: 3, "
      "free: "
      "true}, gain: 0.05}\n"
      "  gravity_torque: {rad_per_s2: {value: 20, free: true}, level_rad: {value: 0.2, free: "
      "true}}\n");
  const auto unknowns = refitted_unknowns(start);
  const Groups all = problem.all_groups();
  EXPECT_GT(std::abs(problem.Problem::fit(start, unknowns, all).value[0] - 4000), 200);
  const Fit fit = problem.fit(start, unknowns, all);
  EXPECT_NEAR(fit.value[0], 4000, 10);
  EXPECT_NEAR(fit.value[1], 1.5, 0.1);
  EXPECT_NEAR(fit.value[2], 30, 1);
}

// A step of the command inside the window of an acceleration looks like a drive that is too weak
// for it. Here the duty is 0.4 at most.
TEST(MotorLogs, AStepIsNotTakenForASaturation) {
  const Model truth = model_of(
      "  motor_servo: {stall_rad_per_s2: 900, back_emf_per_s: 3, gain: 0.02}\n"
      "  gravity_torque: {rad_per_s2: 25, level_rad: 0.4}\n");
  JointsProblem problem = MadeSet("motor-step").made_by(truth, 5);
  const std::vector<double> best = first_start(problem);
  ASSERT_FALSE(best.empty());
  EXPECT_NEAR(best[0] * best[2], 18, 0.2);
  EXPECT_NEAR(best[1], 3, 0.1);
  EXPECT_GT(best[0], 18 * 8 * 2.2);
}

// A motor of 45 rad/s^2 that saturates looks much like one of 400 whose drive is cut off there: no
// limit helps beside the first, so that motor and limit have to move together.
TEST(MotorLogs, ATorqueLimitIsFoundBehindADutyThatStoodInForIt) {
  JointsProblem problem = MadeSet("motor-limit")
                              .made_by(model_of("  motor_servo: {stall_rad_per_s2: 400, "
                                                "back_emf_per_s: 4, gain: 0.045}\n"
                                                "  torque_limit: {rad_per_s2: 42}\n"),
                                       7);
  const std::string stand_in =
      "  motor_servo: {stall_rad_per_s2: {value: 45, free: true}, back_emf_per_s: {value: 2, free: "
      "true}, gain: {value: 0.4, free: true}}\n";
  const auto starts =
      problem.starts_together(model_of(stand_in), *effects::find_effect("torque_limit"), {});
  ASSERT_FALSE(starts.empty());
  EXPECT_NEAR(starts.front()[0], 42, 1);
  const Model start =
      model_of(stand_in + fmt::format("  torque_limit: {{rad_per_s2: {{value: {}, free: true}}}}\n",
                                      starts.front()[0]));
  const Fit fit = fitted_to_all(problem, start);
  EXPECT_NEAR(fit.value[0] * fit.value[2], 18, 0.05);
  EXPECT_NEAR(fit.value[1], 4, 0.05);
  EXPECT_NEAR(fit.value[3], 42, 0.1);
}

// A limit that acts in the largest steps alone, for a few rows: no acceleration shows it.
TEST(MotorLogs, ALimitThatFewRowsFeelIsSeenFromWholeRuns) {
  const Model motor =
      model_of("  motor_servo: {stall_rad_per_s2: 4000, back_emf_per_s: 12, gain: 0.002}\n");
  Model truth = motor;
  truth.add_neutral(effects::find_effect("torque_limit"));
  truth.set_value("torque_limit", 0, 80);
  JointsProblem problem = MadeSet("motor-rare-limit").made_by(truth, 7);
  EXPECT_LT(assess_fixed(problem, motor).error, 1.02);
  const auto starts = problem.starts_together(motor, *effects::find_effect("torque_limit"), {});
  ASSERT_FALSE(starts.empty());
  EXPECT_NEAR(starts.front()[0], 80, 1);
}

// A controller's own damping counts inside the duty, back-EMF outside it: where the duty saturates
// they differ, and the damping is asked for; else it stays at 0 and back-EMF tells of both.
TEST(MotorLogs, DampingComesWhereTheDataAskForIt) {
  const std::string start =
      "  motor_servo: {stall_rad_per_s2: {value: 150, free: true}, back_emf_per_s: {value: 8, "
      "free: "
      "true}, gain: {value: 0.2, free: true}, damping_s: {value: 0, free: true}}\n";
  const auto fit_of = [&](const char* truth) {
    const JointsProblem problem = MadeSet("motor-damping").made_by(model_of(truth), 21);
    const Model given = model_of(start);
    return fitted_to_all(problem, given);
  };
  const Fit saturating = fit_of(
      "  motor_servo: {stall_rad_per_s2: 40, back_emf_per_s: 4, gain: 0.4, damping_s: 0.005}\n");
  EXPECT_NEAR(saturating.value[1], 4, 4 * saturating.sigma[1]);
  EXPECT_NEAR(saturating.value[3], 0.005, 4 * saturating.sigma[3]);
  EXPECT_LT(saturating.sigma[3], 0.0005);
  const Fit calm = fit_of(
      "  motor_servo: {stall_rad_per_s2: 4000, back_emf_per_s: 4, gain: 0.012, damping_s: "
      "0.002}\n");
  EXPECT_EQ(calm.value[3], 0);
  EXPECT_EQ(calm.sigma[3], 0);
  EXPECT_NEAR(calm.value[1], 4 + 4000 * 0.002, 0.05);
}

// The drive is cut off at 40 by the duty in one set and by a limit in the other: a fit that begins
// on the wrong side ends on the right one.
TEST(MotorLogs, ASaturationIsNotALimit) {
  const JointsProblem problem =
      MadeSet("motor-cut")
          .made_by(
              model_of("  motor_servo: {stall_rad_per_s2: 40, back_emf_per_s: 5, gain: 0.4}\n"), 8);
  const Model start = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 320, free: true}, back_emf_per_s: {value: 5, "
      "free: true}, gain: {value: 0.05, free: true}}\n"
      "  torque_limit: {rad_per_s2: {value: 40, free: true}}\n");
  const auto unknowns = refitted_unknowns(start);
  const auto others = cut_off_otherwise(start, unknowns);
  ASSERT_FALSE(others.empty());
  const Fit fit = problem.fit(start, unknowns, problem.all_groups());
  EXPECT_NEAR(fit.value[0], 40, 0.1);
  EXPECT_NEAR(fit.value[1], 5, 0.1);
  EXPECT_NEAR(fit.value[2], 0.4, 0.002);
}

// These runs ask for 0.4 of the duty at most. Where a fit leaves a motor that would saturate just
// above that, other runs would show a saturation that nothing speaks for.
TEST(MotorLogs, ASaturationThatNoRunReachesIsKeptAway) {
  const Model truth =
      model_of("  motor_servo: {stall_rad_per_s2: 900, back_emf_per_s: 6, gain: 0.02}\n");
  const JointsProblem problem = MadeSet("motor-edge").made_by(truth, 11);
  const Model start = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 300, free: true}, back_emf_per_s: {value: 6, "
      "free: "
      "true}, gain: {value: 0.06, free: true}}\n");
  const Fit fit = fitted_to_all(problem, start);
  EXPECT_NEAR(fit.value[0] * fit.value[2], 18, 0.05);
  EXPECT_GT(fit.value[0], 500);
}

// The largest steps ask for a little more than the motor has, for moments.
TEST(MotorLogs, ASaturationForMomentsIsFoundFromTheOtherSide) {
  const JointsProblem problem =
      MadeSet("motor-moments")
          .made_by(
              model_of("  motor_servo: {stall_rad_per_s2: 400, back_emf_per_s: 12, gain: 0.1}\n"),
              11);
  const Fit fit = fitted_to_all(
      problem, model_of("  motor_servo: {stall_rad_per_s2: {value: 2000, free: true}, "
                        "back_emf_per_s: {value: 12, free: true}, gain: {value: 0.02, free: "
                        "true}}\n"));
  EXPECT_NEAR(fit.value[0], 400, 1);
  EXPECT_NEAR(fit.value[2], 0.1, 0.001);
}

// A motor that is nowhere near saturation shows its strength times its gain alone, however small
// one of them is.
TEST(MotorLogs, WhatActsAsAProductIsToldAsAProduct) {
  const JointsProblem problem =
      MadeSet("motor-product")
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 90000, back_emf_per_s: 6, gain: "
                            "2e-4}\n"),
                   13);
  const Model start = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 91000, free: true}, back_emf_per_s: {value: 6, "
      "free: true}, gain: {value: 2e-4, free: true}}\n");
  const Fit fit = fitted_to_all(problem, start);
  EXPECT_NEAR(fit.value[0] * fit.value[2], 18, 0.05);
  EXPECT_NEAR(fit.value[1], 6, 4 * fit.sigma[1]);
  EXPECT_LT(fit.sigma[1], 0.05);
  EXPECT_GT(fit.sigma[0], fit.value[0]);
  EXPECT_GT(fit.sigma[2], fit.value[2]);
}

TEST(MotorLogs, ALogThatBeginsInMotionStartsWithItsRate) {
  // A pendulum that passes 0.1 rad at 2 rad/s, without drive.
  const Model free = model_of(std::string(kMotor) + "  gravity_torque: {rad_per_s2: 60}\n");
  std::string rows;
  const JointLogs shape = [&] {
    for (int k = 0; k < 60; ++k) rows += fmt::format("0,{:.3f},arm,0,0,0\n", 0.01 * k);
    return logs_of(",torque_enable", rows);
  }();
  const auto angles = predict_joint_log(free, shape, shape.logs[0], 0.1, 2.0);
  rows.clear();
  const RandomStream random{8, 2};
  for (int k = 0; k < 60; ++k)
    rows += fmt::format("0,{:.3f},arm,0,{:.6f},0\n", 0.01 * k,
                        angles[static_cast<size_t>(k)] + 0.0003 * normal(random, k));
  EXPECT_NEAR(logs_of(",torque_enable", rows).logs[0].start_radps, 2.0, 0.15);
  // At rest before it falls: no rate, however fast it falls.
  const auto falls = predict_joint_log(free, shape, shape.logs[0], 0.1);
  rows.clear();
  for (int k = 0; k < 60; ++k)
    rows += fmt::format("0,{:.3f},arm,0,{:.6f},0\n", 0.01 * k,
                        falls[static_cast<size_t>(k)] + 0.0003 * normal(random, 100 + k));
  EXPECT_EQ(logs_of(",torque_enable", rows).logs[0].start_radps, 0);
}

// A cubic through rows of rest, a jump of the command and rows of motion begins with a slope, and
// noise of the first step may agree with it.
TEST(MotorLogs, NoiseBeforeAJumpIsNoRate) {
  std::string rows;
  const double mrad[] = {-0.445, 0.427, -0.046, -0.637, -3.778, -8.101, -15.664, -23.970, -34.231};
  for (size_t k = 0; k < std::size(mrad); ++k)
    rows += fmt::format("0,{:.3f},arm,{},{}\n", 0.005 * static_cast<double>(k), k < 2 ? 0 : -0.75,
                        1e-3 * mrad[k]);
  EXPECT_EQ(logs_of("", rows).logs[0].start_radps, 0);
}

// A joint that begins to sag and is held again shows steps of its encoder, at once.
TEST(MotorLogs, StepsOfAnEncoderAreNoRate) {
  const auto rate_of = [&](const std::vector<double>& steps) {
    std::string rows;
    for (size_t k = 0; k < steps.size(); ++k)
      rows +=
          fmt::format("0,{:.3f},arm,0,{:.6f}\n", 0.01 * static_cast<double>(k), 0.0015 * steps[k]);
    // A second run in which the joint moves far enough for the step to be seen.
    for (size_t k = 0; k < 400; ++k)
      rows += fmt::format("1,{:.3f},arm,0,{:.6f}\n", 0.01 * static_cast<double>(k),
                          0.0015 * std::round(200 * std::sin(0.05 * static_cast<double>(k))));
    return logs_of("", rows).logs[0].start_radps;
  };
  EXPECT_EQ(rate_of({0, -1, -2, -2, -2, -2, -2, -2, -2, -2}), 0);
  EXPECT_NEAR(rate_of({0, 7, 13, 20, 27, 33, 40, 47, 53, 60}), 1, 0.05);
}

}  // namespace
}  // namespace seam::measurement
