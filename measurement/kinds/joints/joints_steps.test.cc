// Encoders with steps where the set does not state its noise.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "measurement/kinds/joints/joints_testing.h"

namespace seam::measurement {
namespace {

// Estimated noise holds the rounding: beside the encoder's steps it must not count twice.
TEST(JointSteps, RoundingCountsOnceInNoiseThatIsEstimated) {
  const std::string motor =
      "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.3}\n";
  const Model coarse = model_of(
      motor + fmt::format("  encoder_quantisation: {{step_rad: {}}}\n", std::numbers::pi / 512));
  const JointsProblem problem = MadeSet("motor-steps").made_unstated(coarse, 4);
  const auto error_of = [&](const Model& model) {
    const Score score = score_of(problem, problem.evaluate(model, problem.all_groups(), nullptr));
    return std::sqrt(score.chi2 / static_cast<double>(score.n));
  };
  EXPECT_NEAR(error_of(model_of(motor)), 1, 0.15);
  EXPECT_NEAR(error_of(coarse), 1, 0.15);
}

// A joint that goes from command to command in a few rows: no cubic tells where it is between its
// neighbours, but where it rests its steps flicker as its noise has it.
TEST(JointSteps, RestsTellTheNoiseOfAFastJoint) {
  const Model fast = model_of(
      "  motor_servo: {stall_rad_per_s2: 1200, back_emf_per_s: 37, gain: 0.107}\n"
      "  coulomb_friction: {rad_per_s2: 20}\n" +
      fmt::format("  encoder_quantisation: {{step_rad: {}}}\n", std::numbers::pi / 512));
  const JointsProblem problem = MadeSet("motor-fast-steps").made_unstated(fast, 4);
  const Score score = score_of(problem, problem.evaluate(fast, problem.all_groups(), nullptr));
  EXPECT_NEAR(std::sqrt(score.chi2 / static_cast<double>(score.n)), 1, 0.25);
}

}  // namespace
}  // namespace seam::measurement
