// What pushes a motor beside its effects with names: a formula of the torque says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "measurement/fitting/assess.h"
#include "measurement/kinds/joints/joints_testing.h"
#include "measurement/suggest/suggest.h"

namespace seam::measurement {
namespace {

using testing::ContainsRegex;

constexpr const char* kMotor =
    "  motor_servo: {stall_rad_per_s2: {value: 200, free: true}, "
    "back_emf_per_s: {value: 10, free: true}, gain: {value: 0.1, free: true}}\n"
    "  coulomb_friction: {rad_per_s2: {value: 8, free: true}}\n";

std::optional<Suggestion> suggested(const std::string& name, const std::string& truth) {
  JointsProblem problem =
      MadeSet(name).made_by(model_of(kMotor + ("  hidden: " + truth + "\n")), 6);
  const Model motor = model_of(kMotor);
  problem.prepare(motor);
  return suggest(problem, {.assessment = assess(problem, motor, refitted_unknowns(motor))});
}

TEST(TorqueFormulaSlow, ASpringHasItsPlaceOfRest) {
  const auto found =
      suggested("torque-spring", "{stage: joint, torque: \"-k * (q - 0.3)\", parameters: {k: 20}}");
  ASSERT_TRUE(found);
  EXPECT_LT(found->error, 1.1);
  EXPECT_THAT(found->formula, ContainsRegex("^torque: -(20|19[.][89]|20[.][12])[0-9]* [*] [(]q - "
                                            "0[.](3|29[89]|30[012])[0-9]*[)]$"));
}

// A push acts on all later angles, which swing otherwise than it does.
TEST(TorqueFormulaSlow, ALoadThatRepeatsHasItsPeriod) {
  const auto found = suggested("torque-teeth",
                               "{stage: joint, torque: \"-k * sin(16 * q)\", parameters: {k: 12}}");
  ASSERT_TRUE(found);
  EXPECT_LT(found->error, 1.1);
  EXPECT_THAT(found->formula, ContainsRegex("^torque: -?1[12][0-9.]* [*] sin[(]2 [*] pi [*] q / "
                                            "0[.]39[23][0-9]* [+-] [0-9.]+[)]$"));
}

TEST(TorqueFormulaSlow, FrictionInOnePlaceIsABump) {
  const auto found = suggested("torque-spot",
                               "{stage: joint, torque: \"-k * sign(rate) * exp(-((q - 0.2) / "
                               "0.15)^2)\", parameters: {k: 15}}");
  ASSERT_TRUE(found);
  EXPECT_LT(found->error, 1.1);
  EXPECT_THAT(found->formula, ContainsRegex("^torque: -1[45][0-9.]* [*] sign[(]rate[)] [*] "
                                            "exp[(]-[(][(]q - 0[.](2|19)[0-9]*[)] / "
                                            "0[.]1[45][0-9]*[)]\\^2[)]$"));
}

TEST(TorqueFormulaSlow, AMotorThatWeakensLosesOfItsDrive) {
  const auto found =
      suggested("torque-weak", "{stage: joint, torque: \"-k * drive * t\", parameters: {k: 0.06}}");
  ASSERT_TRUE(found);
  EXPECT_LT(found->error, 1.1);
  EXPECT_THAT(found->formula, ContainsRegex("^torque: -0[.]0(6|59)[0-9]* [*] drive [*] t$"));
}

}  // namespace
}  // namespace seam::measurement
