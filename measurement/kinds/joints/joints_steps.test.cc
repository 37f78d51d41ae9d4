// Encoders with steps: how their rounding counts, and that their step is found.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/kinds/joints/joints_testing.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/models/add_effects.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

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

// What another servo changes is whitened by the wander as the residuals are.
TEST(JointWander, WhitensAColumnAsTheResiduals) {
  const auto servo = [](double stall_rad_per_s2) {
    return model_of(
        fmt::format("  motor_servo: {{stall_rad_per_s2: {}, back_emf_per_s: 10, gain: 0.3}}\n"
                    "  joint_wander: {{sigma_rad: 0.003, tau_s: 0.5}}\n",
                    stall_rad_per_s2));
  };
  const Model model = servo(200);
  const JointsProblem problem = MadeSet("motor-wander-column").made_by(model, 3);
  const Groups all = problem.all_groups();
  const Evaluation here = problem.evaluate(model, all, nullptr),
                   there = problem.evaluate(servo(210), all, nullptr);
  std::vector<double> column(here.residual.size());
  for (size_t i = 0; i < column.size(); ++i)
    column[i] = (there.residual[i] - here.residual[i]) / here.sigma[i];
  const auto followed = problem.following(model, all, here, {column});
  ASSERT_EQ(followed.size(), 1u);
  double most = 0;
  for (size_t i = 0; i < column.size(); ++i) {
    EXPECT_NEAR(followed[0][i], there.whitened[i] - here.whitened[i], 1e-6) << i;
    most = std::max(most, std::abs(followed[0][i]));
  }
  EXPECT_GT(most, 0.1);
}

// Logs of a joint that follows its command with a lag, rounded to steps, in digits of many files.
constexpr double kDegreesOfRadian = 180 / std::numbers::pi, kLoggedNoise_rad = 4e-4,
                 kTrueLag_s = 0.06;

double rounded_to(double value, double to) {
  return std::round(value / to) * to;
}

// How an angle stands in a file, in radians with 9 decimals after it was converted.
using WrittenAngle = std::function<double(double)>;
double degrees_4(double x) {
  return rounded_to(x * kDegreesOfRadian, 1e-4) / kDegreesOfRadian;
}
double radians_4(double x) {
  return rounded_to(x, 1e-4);
}
double radians(double x) {
  return x;
}

// What a log is made of: commands, what noise there is before the angle is rounded and written, and
// whether the set states it.
struct LagLog {
  double step_rad = 0;
  WrittenAngle written = radians;
  double noise_rad = kLoggedNoise_rad;
  bool stated = true;
  int rows = 150;
  std::function<double(int run, int row)> command_rad = [](int run, int row) {
    return 0.9 * std::sin(0.9 * run + 0.07 * row);  // Never at rest.
  };
};

std::filesystem::path write_log(const std::string& name, const LagLog& log) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("steps-" + name);
  std::filesystem::create_directories(folder);
  std::string rows = "run,time_s,joint,command_rad,measured_rad\n";
  uint64_t draw = 0;
  for (int run = 0; run < 6; ++run) {
    double angle = 0;
    for (int k = 0; k < log.rows; ++k) {
      const double command = log.command_rad(run, k);
      if (k == 0) angle = command;
      const double seen = angle + log.noise_rad * normal({7, 2}, draw++);
      const double shown = log.step_rad > 0 ? rounded_to(seen, log.step_rad) : seen;
      rows +=
          fmt::format("{},{:.2f},pan,{:.6f},{:.9f}\n", run, 0.02 * k, command, log.written(shown));
      angle += (command - angle) * (1 - std::exp(-0.02 / kTrueLag_s));
    }
  }
  write_file_atomically(folder / "joints.csv", rows);
  const std::string noise =
      log.stated ? fmt::format("noise: {{measured_rad: {}}}\n", log.noise_rad) : "";
  write_file_atomically(folder / "measurement.yaml",
                        fmt::format("format: seam-measurement/1\nkind: joints\ntitle: steps\n"
                                    "{}group: run\nfiles: {{joints: joints.csv}}\n",
                                    noise));
  return folder;
}

Model lag_model() {
  return model_of("  servo_lag: {tau_s: {value: 0.05, free: true}}\n");
}

TEST(JointSteps, AreFoundInAnyDigits) {
  constexpr double kTick = 2 * std::numbers::pi / 1024;
  for (const auto& [name, step, written] :
       std::initializer_list<std::tuple<std::string, double, WrittenAngle>>{
           {"degrees", kTick, degrees_4},
           {"few-decimals", kTick, radians_4},
           {"ticks", kTick, radians},
           {"odd", 0.0037, degrees_4}}) {
    const auto problem = open_problem(write_log(name, {.step_rad = step, .written = written}));
    const auto effect = effects::find_effect("encoder_quantisation");
    ASSERT_EQ(effects::reason_against(*effect, 0, problem->facts().set), "") << name;
    const AddResult added = add_effects(*problem, lag_model(), {effect});
    EXPECT_GT(added.error_before, 1.5) << name;
    EXPECT_NEAR(added.error_after, 1, 0.12) << name;
    EXPECT_NEAR(added.model.find("encoder_quantisation")->values()[0], step, 0.02 * step) << name;
    EXPECT_NEAR(added.model.find("servo_lag")->values()[0], kTrueLag_s, 2e-3) << name;
  }
}

TEST(JointSteps, NoneAreSeenWhereThereAreNone) {
  for (const auto& [name, written] : std::initializer_list<std::pair<std::string, WrittenAngle>>{
           {"none-degrees", degrees_4}, {"none", radians}}) {
    const auto problem = open_problem(write_log(name, {.written = written}));
    EXPECT_THAT(effects::reason_against(*effects::find_effect("encoder_quantisation"), 0,
                                        problem->facts().set),
                testing::HasSubstr("multiples of no step"))
        << name;
  }
}

// Where the set states no noise its estimate holds the rounding. Steps are likelier all the same,
// and nothing that moves less than a step takes their place.
TEST(JointSteps, AreFoundWhereNoNoiseIsStated) {
  for (const double degrees : {0.2371, 0.3317}) {
    const double step_rad = degrees / kDegreesOfRadian;
    LagLog log{.step_rad = step_rad, .written = degrees_4, .noise_rad = 0, .stated = false};
    log.command_rad = [](int run, int row) {
      return uniform({5, static_cast<uint64_t>(run)}, static_cast<uint64_t>(row / 30)) - 0.5;
    };
    const auto problem = open_problem(write_log(fmt::format("unstated-{}", degrees), log));
    const auto likelihood_with = [&](const std::string& name) {
      const AddResult added = add_effects(*problem, lag_model(), {effects::find_effect(name)});
      if (name == "encoder_quantisation") {
        EXPECT_NEAR(added.model.find(name)->values()[0], step_rad, 0.02 * step_rad);
      }
      return problem->score(added.model, problem->all_groups()).log_likelihood;
    };
    EXPECT_GT(likelihood_with("encoder_quantisation"), likelihood_with("stiction") + 20) << degrees;
  }
}

// A joint without noise goes from rest to rest: where it rests its rounding is one error, however
// many rows show it, and no structure of time or place.
TEST(JointSteps, ARestShowsOneErrorOfRounding) {
  const double step_rad = 0.29 / kDegreesOfRadian;
  LagLog log{
      .step_rad = step_rad, .written = degrees_4, .noise_rad = 0, .stated = false, .rows = 600};
  log.command_rad = [](int run, int row) {
    return 1.8 * (uniform({11, static_cast<uint64_t>(run)}, static_cast<uint64_t>(row / 40)) - 0.5);
  };
  const auto problem = open_problem(write_log("rests", log));
  const Model truth =
      model_of(fmt::format("  servo_lag: {{tau_s: {}}}\n  encoder_quantisation: {{step_rad: {}}}\n",
                           kTrueLag_s, step_rad));
  for (const Structure& s : problem->structure(truth, problem->all_groups(), 2))
    EXPECT_GT(s.p_value, 1e-3) << s.moment << " of " << s.covariate;
}

}  // namespace
}  // namespace seam::measurement
