// Encoders with steps where the set does not state its noise.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "measurement/kinds/joints/joints_testing.h"

namespace seam::measurement {
namespace {

// Root mean square of the errors of a model on sets of `truth` without a stated noise. Each rest of
// a joint is one draw of the place between steps, so that a single set says little.
double error_over_sets(const Model& truth, const Model& model) {
  constexpr uint64_t kSets = 10;
  double sum = 0;
  for (uint64_t seed = 0; seed < kSets; ++seed) {
    const JointsProblem problem = MadeSet("motor-steps").made_unstated(truth, 4 + seed);
    const Score score = score_of(problem, problem.evaluate(model, problem.all_groups(), nullptr));
    sum += score.chi2 / static_cast<double>(score.n) / kSets;
  }
  return std::sqrt(sum);
}

const std::string kSteps =
    fmt::format("  encoder_quantisation: {{step_rad: {}}}\n", std::numbers::pi / 512);

// Estimated noise holds the rounding: beside the encoder's steps it must not count twice.
TEST(JointSteps, RoundingCountsOnceInNoiseThatIsEstimated) {
  const std::string motor =
      "  motor_servo: {stall_rad_per_s2: 200, back_emf_per_s: 10, gain: 0.3}\n";
  const Model coarse = model_of(motor + kSteps);
  EXPECT_NEAR(error_over_sets(coarse, model_of(motor)), 1, 0.15);
  EXPECT_NEAR(error_over_sets(coarse, coarse), 1, 0.15);
}

// A joint that goes from command to command in a few rows: no cubic tells where it is between its
// neighbours, but where it rests its steps flicker as its noise has it.
TEST(JointSteps, RestsTellTheNoiseOfAFastJoint) {
  const Model fast = model_of(
      "  motor_servo: {stall_rad_per_s2: 1200, back_emf_per_s: 37, gain: 0.107}\n"
      "  coulomb_friction: {rad_per_s2: 20}\n" +
      kSteps);
  EXPECT_NEAR(error_over_sets(fast, fast), 1, 0.25);
}

// Far in a step an angle says nothing; beyond its edge it is off by the noise alone.
TEST(JointSteps, AnAngleIsOffByWhatIsBeyondItsStep) {
  constexpr double kStep = 0.01, kNoise = 0.001;
  const RoundedAngle rounded(kStep, kNoise);
  EXPECT_EQ(rounded.z(0), 0);
  EXPECT_NEAR(rounded.z(0.3 * kStep), 0, 0.3);
  EXPECT_DOUBLE_EQ(rounded.z(-kStep), -rounded.z(kStep));
  EXPECT_NEAR(rounded.z(6 * kStep), 55, 0.2);
  EXPECT_NEAR(rounded.slope(6 * kStep), 1 / kNoise, 2);
  // The likeliest angle has the density of one a step.
  EXPECT_NEAR(rounded.sigma_rad() * std::sqrt(2 * std::numbers::pi), kStep, 1e-6);
  const RandomStream random{3, 0};
  constexpr uint64_t kDraws = 100000;
  double square = 0;
  for (uint64_t k = 0; k < kDraws; ++k) {
    const double angle = kStep * uniform(random, 2 * k),
                 seen = angle + kNoise * normal(random, 2 * k + 1);
    const double z = rounded.z(kStep * std::round(seen / kStep) - angle);
    square += z * z / kDraws;
  }
  EXPECT_NEAR(square / rounded.mean_square(), 1, 0.03);
}

// An error that wanders follows the rounding of a joint at rest.
TEST(JointSteps, AWanderIsNoLikelierThanTheStepsThatMadeIt) {
  const std::string fast =
      "  motor_servo: {stall_rad_per_s2: 1200, back_emf_per_s: 37, gain: 0.107}\n"
      "  coulomb_friction: {rad_per_s2: 20}\n" +
      kSteps;
  const JointsProblem problem = MadeSet("motor-wander-steps").made_unstated(model_of(fast), 4);
  const auto likelihood_of = [&](const std::string& effects) {
    return problem.score(model_of(effects), problem.all_groups()).log_likelihood;
  };
  EXPECT_GT(likelihood_of(fast),
            likelihood_of(fast + "  joint_wander: {sigma_rad: 0.0015, tau_s: 0.9}\n") + 10);
}

}  // namespace
}  // namespace seam::measurement
