// Drag before and behind a saturation: what moves alike, and that fits end with the fewer effects.
#include "measurement/kinds/joints/torque/damped_motor.h"

#include <gtest/gtest.h>

#include <cmath>

#include "measurement/kinds/joints/joints_testing.h"

namespace seam::measurement {
namespace {

// Steps to and fro that ask for more than the duty gives.
JointLogs steps() {
  std::string rows = "run,time_s,joint,command_rad,measured_rad\n";
  for (int k = 0; k < 200; ++k)
    rows += fmt::format("0,{:.2f},arm,{},0\n", 0.01 * k, k / 50 % 2 == 0 ? 0.8 : -0.6);
  return read_joint_logs(CsvTable::from_text(rows, "joints.csv"), "run", true);
}

TEST(DampedMotor, ALimitWithViscousFrictionMovesAsADampedControllerDoes) {
  const effects::Model limited = model_of(
      "  motor_servo: {stall_rad_per_s2: 700, back_emf_per_s: 8, gain: 0.5}\n"
      "  viscous_friction: {per_s: 5}\n"
      "  torque_limit: {rad_per_s2: 60}\n");
  const auto damped = damped_alike(limited);
  ASSERT_TRUE(damped);
  const auto motor = damped->find("motor_servo")->values();
  EXPECT_NEAR(motor[0], 60, 1e-9);
  EXPECT_NEAR(motor[1], 5, 1e-9);
  EXPECT_NEAR(motor[2], 0.5 * 700 / 60, 1e-9);
  EXPECT_NEAR(motor[3], 8.0 / 60, 1e-9);
  EXPECT_EQ(damped->find("viscous_friction")->values()[0], 0);
  EXPECT_TRUE(std::isinf(damped->find("torque_limit")->values()[0]));
  const JointLogs set = steps();
  const auto one = predict_joint_log(limited, set, set.logs[0], 0);
  const auto other = predict_joint_log(*damped, set, set.logs[0], 0);
  for (size_t k = 0; k < one.size(); ++k) EXPECT_NEAR(one[k], other[k], 1e-6) << k;
  EXPECT_FALSE(
      damped_alike(model_of("  motor_servo: {stall_rad_per_s2: 700, back_emf_per_s: 8, gain: 0.5}\n"
                            "  torque_limit: {rad_per_s2: 60}\n")));
}

TEST(DampedMotor, SharesOfTheDragMoveAlikeWhereNothingSaturates) {
  const effects::Model motor =
      model_of("  motor_servo: {stall_rad_per_s2: 400, back_emf_per_s: 12, gain: 0.2}\n");
  const JointLogs set = steps();
  const auto plain = predict_joint_log(motor, set, set.logs[0], 0);
  const auto others = damped_otherwise(motor);
  ASSERT_EQ(others.size(), 3u);
  for (const effects::Model& other : others) {
    const auto angles = predict_joint_log(other, set, set.logs[0], 0);
    for (size_t k = 0; k < plain.size(); ++k) EXPECT_NEAR(angles[k], plain[k], 1e-6) << k;
    EXPECT_GT(other.find("motor_servo")->values()[3], 0);
  }
  EXPECT_TRUE(damped_otherwise(model_of("  ideal_servo: {}\n")).empty());
}

TEST(DampedMotor, AControllerThatHasAllTheDragIsALimitOfTorque) {
  const std::vector<Unknown> unknowns = {{"motor_servo", 1}, {"motor_servo", 3}};
  const auto fit_of = [&](const std::string& back_emf, const std::string& damping, double sigma) {
    Fit fit;
    fit.model = model_of("  motor_servo: {stall_rad_per_s2: 400, back_emf_per_s: " + back_emf +
                         ", gain: 0.2, damping_s: " + damping + "}\n");
    fit.sigma = {sigma, 0.001};
    return fit;
  };
  EXPECT_TRUE(keeps_back_emf(fit_of("4", "0.03", 2), unknowns));
  EXPECT_FALSE(keeps_back_emf(fit_of("1", "0.03", 0.5), unknowns));
  EXPECT_TRUE(keeps_back_emf(fit_of("1", "0.03", 0.1), unknowns));  // Little, but surely some.
  const Fit all = fit_of("0", "0.03", 0.1);
  const auto without = undamped(all.model, unknowns);
  ASSERT_TRUE(without);
  EXPECT_NEAR(without->find("motor_servo")->values()[1], 12, 1e-9);
  EXPECT_EQ(without->find("motor_servo")->values()[3], 0);
  EXPECT_FALSE(undamped(all.model, {{"motor_servo", 1}}));
  EXPECT_FALSE(undamped(fit_of("12", "0", 0.1).model, unknowns));
}

const char* const kLimited =
    "  motor_servo: {stall_rad_per_s2: 400, back_emf_per_s: 8, gain: 0.12}\n"
    "  torque_limit: {rad_per_s2: 60}\n";
const char* const kDamped =
    "  motor_servo: {stall_rad_per_s2: {value: 61, free: true}, back_emf_per_s: {value: 1, free: "
    "true}, gain: {value: 0.8, free: true}, damping_s: {value: 0.12, free: true}}\n";

TEST(DampedMotor, DampingGoesWhereOnlyALimitIsMissing) {
  const JointsProblem problem = MadeSet("motor-undamped").made_by(model_of(kLimited), 3);
  const Fit fit = fitted_to_all(problem, model_of(kDamped));
  EXPECT_EQ(fit.value[3], 0);
  EXPECT_GT(fit.value[1], 1);
}

// Nearly all of the drag is the controller's, and nothing else is missing: without damping, too,
// the fit ends near the noise, but the data ask for it.
TEST(DampedMotor, DampingThatTheDataAskForStaysBesideLittleBackEmf) {
  const Model truth = model_of(
      "  motor_servo: {stall_rad_per_s2: {value: 465, free: true}, back_emf_per_s: {value: 0.5, "
      "free: true}, gain: {value: 0.1, free: true}, damping_s: {value: 0.0328, free: true}}\n");
  const JointsProblem problem = MadeSet("motor-damped-little").made_by(truth, 3);
  const Fit fit = fitted_to_all(problem, truth);
  EXPECT_NEAR(fit.value[0], 465, 5);
  EXPECT_NEAR(fit.value[3], 0.0328, 0.002);
}

// Beside errors that wander nothing seems to be missing: the mean alone says what is.
TEST(DampedMotor, DampingGoesBesideAWanderToo) {
  const JointsProblem problem = MadeSet("motor-undamped-wander").made_by(model_of(kLimited), 3);
  const Fit fit = fitted_to_all(
      problem, model_of(std::string(kDamped) +
                        "  joint_wander: {sigma_rad: {value: 0.001, free: true}, tau_s: 1}\n"));
  EXPECT_EQ(fit.value[3], 0);
  EXPECT_GT(fit.value[1], 1);
}

// Where friction is one by load, a limit with viscous friction moves as no damped controller does,
// and no slope leads from one to the other.
TEST(DampedMotor, ADampedControllerIsFoundFromALimitBesideFrictionByLoad) {
  const std::string friction =
      "  coulomb_friction: {rad_per_s2: {value: 152, free: true}}\n"
      "  load_friction: {fraction: {value: 0.22, free: true}}\n";
  const JointsProblem problem =
      MadeSet("motor-limit-load", false)
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 800, back_emf_per_s: 6.5, gain: "
                            "0.6, damping_s: 0.036}\n" +
                            friction),
                   3);
  const Fit fit = fitted_to_all(
      problem, model_of("  motor_servo: {stall_rad_per_s2: {value: 720000, free: true}, "
                        "back_emf_per_s: {value: 35.7, free: true}, gain: {value: 0.00067, free: "
                        "true}, damping_s: {value: 0, free: true}}\n" +
                        friction +
                        "  viscous_friction: {per_s: {value: 0.5, free: true}}\n"
                        "  torque_limit: {rad_per_s2: {value: 784, free: true}}\n"));
  EXPECT_NEAR(fit.value[0], 800, 10);
  EXPECT_NEAR(fit.value[1], 6.5, 1);
  EXPECT_NEAR(fit.value[3], 0.036, 0.002);
}

// A duty that saturates and a limit of torque within it look like one saturation between the two,
// with drag on both sides of it.
TEST(DampedMotor, TwoSaturationsAreFoundFromOneBetweenThem) {
  const JointsProblem problem =
      MadeSet("motor-two-saturations", false)
          .made_by(model_of("  motor_servo: {stall_rad_per_s2: 1160, back_emf_per_s: 34, gain: "
                            "0.3}\n  coulomb_friction: {rad_per_s2: 200}\n"
                            "  torque_limit: {rad_per_s2: 685}\n"),
                   3);
  const Fit fit = fitted_to_all(
      problem,
      model_of("  motor_servo: {stall_rad_per_s2: {value: 809, free: true}, back_emf_per_s: "
               "{value: 18.7, free: true}, gain: {value: 0.43, free: true}, damping_s: {value: "
               "0.019, free: true}}\n  coulomb_friction: {rad_per_s2: {value: 200, free: true}}\n"
               "  torque_limit: {rad_per_s2: {value: 5000, free: true}}\n"));
  EXPECT_NEAR(fit.value[0], 1160, 10);
  EXPECT_EQ(fit.value[3], 0);
  EXPECT_NEAR(fit.value[5], 685, 5);
}

}  // namespace
}  // namespace seam::measurement
