// What searches do where a motor's fit ended in a wrong place, or where its slopes mislead.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "effects/registry.h"
#include "measurement/fitting/assess.h"
#include "measurement/infer/unnamed.h"
#include "measurement/judge/decisions.h"
#include "measurement/judge/material.h"
#include "measurement/kinds/joints/joints_testing.h"
#include "measurement/search/choice.h"
#include "measurement/search/order.h"

namespace seam::measurement {
namespace {

const char* const kFree =
    "  motor_servo: {stall_rad_per_s2: {value: 200, free: true}, back_emf_per_s: {value: 10, free: "
    "true}, gain: {value: 0.1, free: true}}\n";

double rms_of(const std::vector<double>& values) {
  double sum2 = 0;
  for (const double value : values) sum2 += value * value;
  return std::sqrt(sum2 / static_cast<double>(values.size()));
}

TEST(MotorSearch, PartsOfAMotorAreAllFittedWhileItMisses) {
  const JointsProblem problem =
      MadeSet("motor-parts")
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: "
                            "0.1}\n  coulomb_friction: {rad_per_s2: 8}\n  gravity_torque: "
                            "{rad_per_s2: 20, level_rad: 0.3}\n"),
                   6);
  const Model base = model_of(kFree);
  const Grown here{.added = {"motor_servo"},
                   .assessment = assess(problem, base, refitted_unknowns(base))};
  ASSERT_GT(here.assessment.error, 2);
  const Looks looks = look_at(problem, here, absent_effects(problem, here.assessment.model, {}),
                              0.1, /*promising_only=*/true);
  for (const char* name : {"gravity_torque", "viscous_friction", "coulomb_friction",
                           "stribeck_friction", "load_friction"}) {
    EXPECT_TRUE(std::any_of(looks.candidates.begin(), looks.candidates.end(),
                            [&](const Candidate& c) { return c.effect->name == name; }))
        << name;
  }
}

// Fast steps and long rests: most accelerations are those of a motor that does nothing.
TEST(MotorSearch, AJointThatRestsMostOfItsTimeHasAMotor) {
  const JointsProblem problem =
      MadeSet("motor-rests")
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 2000, back_emf_per_s: 37, gain: "
                            "0.05}\n  stribeck_friction: {rad_per_s2: 20, rad_per_s: 0.9}\n"),
                   6);
  const auto starts =
      problem.starts_together(model_of("  ideal_servo: {}\n"), *effects::find_effect("motor_servo"),
                              {effects::find_effect("gravity_torque")});
  ASSERT_FALSE(starts.empty());
  EXPECT_NEAR(starts.front()[0] * starts.front()[2], 2000 * 0.05, 20);
}

// The waves in a turn are told from their neighbours and from twice as many; without cogging there
// is nothing to begin at.
TEST(MotorSearch, CoggingIsSeenInTheMotion) {
  const std::string motor =
      "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.1}\n"
      "  coulomb_friction: {rad_per_s2: 3}\n";
  const EffectDefinition& cogging = *effects::find_effect("torque_cogging");
  const auto starts = [&](const std::string& more) {
    return MadeSet("motor-cogging")
        .made_by(model_of(motor + more), 6)
        .starts(model_of(motor), cogging);
  };
  EXPECT_TRUE(starts("").empty());
  for (const double waves : {9.0, 31.0}) {
    const auto seen = starts(
        fmt::format("  torque_cogging: {{rad_per_s2: 4, per_turn: {}, phase_rad: 0.5}}\n", waves));
    ASSERT_EQ(seen.size(), 1u) << waves;
    EXPECT_NEAR(seen[0][0], 4, 1) << waves;
    EXPECT_NEAR(seen[0][1], waves, 0.2) << waves;
    EXPECT_NEAR(std::remainder(seen[0][2] - 0.5, 2 * M_PI), 0, 0.3) << waves;
  }
}

// Motors are dear to fit: one is tried only where the motion over short stretches asks for it.
TEST(MotorSearch, WhatDependsOnTheAngleAloneAsksForNoMotor) {
  const std::string lag = "  servo_lag: {tau_s: 0.06}\n";
  const JointsProblem problem =
      MadeSet("motor-none", /*releases=*/false)
          .made_by(model_of(lag + "  encoder_eccentricity: {amplitude_rad: 0.005}\n"), 6);
  const auto motor = effects::find_effect("motor_servo");
  const EffectList load = {effects::find_effect("gravity_torque")};
  EXPECT_TRUE(problem.starts_together(model_of(lag), *motor, load).empty());
}

// The measured angle holds the very noise that stands in the residual; the predicted one does not.
TEST(JointFields, AnErrorThatRepeatsOverTheTurnDependsOnThePredictedAngle) {
  const Model lag = model_of("  servo_lag: {tau_s: 0.06}\n");
  const JointsProblem problem =
      MadeSet("field-angle", /*releases=*/false)
          .made_by(model_of("  servo_lag: {tau_s: 0.06}\n"
                            "  encoder_eccentricity: {amplitude_rad: 0.001}\n"),
                   6);
  const Evaluation here = problem.evaluate(lag, problem.all_groups(), nullptr);
  const std::vector<FieldPlace> places = problem.field_places(lag, here);
  ASSERT_EQ(places.size(), 1u);
  EXPECT_EQ(places[0].covariates[0].name, "arm");
  EXPECT_EQ(places[0].covariates[1].name, "arm_rate");
  const Assessment given = assess_fixed(problem, lag);
  const auto cause = unnamed_cause(problem, {{&given, given.total_ll}}, kMaterial, KnownCauses{1});
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->depends_on[0][0], "arm");
  EXPECT_NEAR(cause->error_after, 1, 0.1);
}

// A torque acts on all later angles: against loads that are changed a little, one of them constant.
TEST(JointFields, ATorqueReachesAllLaterAngles) {
  const std::string rest =
      "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.1}\n"
      "  coulomb_friction: {rad_per_s2: 3}\n";
  const auto with = [&](double gravity, double constant) {
    return model_of(rest + fmt::format("  gravity_torque: {{rad_per_s2: {}, level_rad: 0}}\n"
                                       "  friction_asymmetry: {{rad_per_s2: {}}}\n",
                                       gravity, constant));
  };
  const Model model = with(20, 0);
  const JointsProblem problem = MadeSet("field-torque").made_by(model, 6);
  const Groups all = problem.all_groups();
  const Evaluation here = problem.evaluate(model, all, nullptr);
  const std::vector<FieldPlace> places = problem.field_places(model, here);
  ASSERT_EQ(places.size(), 2u);
  EXPECT_EQ(places[1].covariates.back().name, "time");
  constexpr double kBy = 0.001;
  const auto change = [&](const Model& other) {
    std::vector<double> change = problem.evaluate(other, all, &here).residual;
    for (size_t i = 0; i < change.size(); ++i) change[i] = (change[i] - here.residual[i]) / kBy;
    return change;
  };
  const std::vector<double> by_constant = change(with(20, kBy)),
                            by_gravity = change(with(20 + kBy, 0));
  std::vector<double> constant = places[1].slopes[0], gravity = constant;
  for (size_t i = 0; i < gravity.size(); ++i)
    gravity[i] *= std::cos(places[1].covariates[0].values[i]);
  places[1].arrives(constant), places[1].arrives(gravity);
  const double unit = rms_of(by_constant);
  EXPECT_NEAR(rms_of(constant), 1, 1e-9);
  EXPECT_NEAR(rms_of(gravity), rms_of(by_gravity) / unit, 0.01);
  const auto misses = [&](std::vector<double> of, const std::vector<double>& by) {
    for (size_t i = 0; i < of.size(); ++i) of[i] -= by[i] / unit;
    return rms_of(of);
  };
  EXPECT_LT(misses(constant, by_constant), 0.02);
  EXPECT_LT(misses(gravity, by_gravity), 0.02);
  EXPECT_GT(misses(gravity, by_constant), 0.1);
}

// A load acts on the torque, and on no angle as such.
TEST(JointFields, ATorqueWithoutANameIsFoundByTheAngle) {
  const std::string motor =
      "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.1}\n";
  const JointsProblem problem =
      MadeSet("field-load")
          .made_by(model_of(motor + "  gravity_torque: {rad_per_s2: 4, level_rad: 0.3}\n"), 6);
  const Assessment given = assess_fixed(problem, model_of(motor));
  const auto cause = unnamed_cause(problem, {{&given, given.total_ll}}, kMaterial, KnownCauses{1});
  ASSERT_TRUE(cause);
  EXPECT_EQ(cause->depends_on[0][0], "arm");
  EXPECT_LT(cause->error_after, 0.2 * given.error);
}

// Friction holds this joint wherever its command calls it: rows at rest say of a motor without any
// that neither drive nor load is there (a load of 36 where they count, 54 where they do not).
TEST(MotorSearch, AJointThatFrictionHoldsHasAMotorAndALoad) {
  const JointsProblem problem =
      MadeSet("motor-held", /*releases=*/false, Commands::slow_sines)
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 100, back_emf_per_s: 5, gain: 0.1}\n"
                            "  gravity_torque: {rad_per_s2: 70, level_rad: 1.57}\n"
                            "  load_friction: {fraction: 0.2, carried_fraction: 0.3}\n"),
                   6);
  const auto starts =
      problem.starts_together(model_of("  ideal_servo: {}\n"), *effects::find_effect("motor_servo"),
                              {effects::find_effect("gravity_torque")});
  ASSERT_FALSE(starts.empty());
  EXPECT_NEAR(std::abs(starts.front()[5]), 70, 20);
}

// Back-EMF and viscous friction are one where nothing is released, and so are, but for little, all
// torques together beside a friction by load: differences that bend told them apart.
TEST(MotorSearch, ErrorsSayWhatTheDataDoNotTell) {
  const JointsProblem problem =
      MadeSet("motor-untold", false)
          .made_by(
              model_of("  motor_servo: {stall_rad_per_s2: 214, back_emf_per_s: 22, gain: 0.163}\n"
                       "  gravity_torque: {rad_per_s2: 44, level_rad: 1.4}\n"
                       "  coulomb_friction: {rad_per_s2: 23}\n"),
              5);
  const Model given = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 214, free: true}, back_emf_per_s: {value: 14, "
      "free: "
      "true}, gain: {value: 0.163, free: true}}\n"
      "  gravity_torque: {rad_per_s2: {value: 44, free: true}, level_rad: {value: 1.4, free: "
      "true}}\n"
      "  coulomb_friction: {rad_per_s2: {value: 23, free: true}}\n"
      "  viscous_friction: {per_s: {value: 8, free: true}}\n");
  const Fit fit = fitted_to_all(problem, given);
  const auto unknowns = refitted_unknowns(given);
  for (size_t k = 0; k < unknowns.size(); ++k) {
    const bool untold = unknowns[k].effect == "viscous_friction" ||
                        (unknowns[k].effect == "motor_servo" && unknowns[k].parameter == 1);
    if (untold) {
      EXPECT_GT(fit.sigma[k], 50) << unknowns[k].effect;
    } else {
      EXPECT_LT(fit.sigma[k], 0.01 * fit.value[k]) << unknowns[k].effect;
    }
  }
}

// A motor that misses by far is not told by errors that wander, which leave its misses as alike as
// they were; errors that do wander are, however large.
TEST(MotorSearch, AWanderThatLeavesWhatItIsForHidesTheMean) {
  const std::string motor =
      "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.1}\n";
  const auto hides = [&](const std::string& truth) {
    const JointsProblem problem = MadeSet("motor-hides").made_by(model_of(truth), 6);
    const Model base = model_of(kFree);
    const Grown here{.added = {"motor_servo"},
                     .assessment = assess(problem, base, refitted_unknowns(base))};
    EXPECT_GT(here.assessment.error, kUseless);
    const Looks looks = look_at(problem, here, {effects::find_effect("joint_wander")}, 0.1);
    return hides_mean(problem, here.assessment, looks.candidates.front().grown.assessment);
  };
  EXPECT_TRUE(hides(motor + "  coulomb_friction: {rad_per_s2: 8}\n"
                            "  gravity_torque: {rad_per_s2: 20, level_rad: 0.3}\n"));
  EXPECT_FALSE(hides(motor + "  joint_wander: {sigma_rad: 0.02, tau_s: 0.5}\n"));
}

// Alone the wander of a motor's log leaves no misfit at all: it is told after the motor.
TEST(MotorSearch, StepsTellTheMotorBeforeItsWander) {
  const JointsProblem problem =
      MadeSet("motor-steps-wander")
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: "
                            "0.1}\n  joint_wander: {sigma_rad: 0.003, tau_s: 0.5}\n"),
                   6);
  const Model base = model_of("  ideal_servo: {}\n");
  const Model best = model_of(
      std::string(kFree) +
      "  joint_wander: {sigma_rad: {value: 0.003, free: true}, tau_s: {value: 0.5, free: true}}\n");
  SearchResult result;
  result.base.assessment = assess(problem, base, {});
  result.best = {.added = {"joint_wander", "motor_servo"},
                 .assessment = assess(problem, best, refitted_unknowns(best))};
  ASSERT_LT(result.best.assessment.error, 1.15);
  const auto by_name = [](const std::string& name) { return effects::find_effect(name); };
  order_steps(problem, by_name, result);
  ASSERT_EQ(result.steps.size(), 2u);
  EXPECT_EQ(result.steps[0].effect, "motor_servo");
}

}  // namespace
}  // namespace seam::measurement
