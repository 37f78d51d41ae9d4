// Noise that is not white: named where a model lacks it, and no alarm where the model has it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>

#include "measurement/kinds/kinds.h"
#include "measurement/search/order.h"
#include "measurement/study/study.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

struct NoiseCase {
  std::string kind, base, noise;  // Effects as in a model file.
  std::string name() const { return noise.substr(0, noise.find(':')); }
  friend void PrintTo(const NoiseCase& c, std::ostream* out) { *out << c.kind << ": " << c.name(); }
};

Model noise_model(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "noise"));
}

std::unique_ptr<Problem> noise_set(const NoiseCase& c, const Model& truth) {
  const fs::path protocol = fs::path(testing::TempDir()) / ("noise-" + c.name()),
                 out = protocol.string() + "-set";
  write_study_protocol(c.kind, protocol);
  fs::remove_all(out);
  measure_set(truth, MeasurementSet::open(protocol), {.seed = 15, .out = out});
  return open_problem(out);
}

SearchResult searched_for_noise(Problem& problem, const Model& model) {
  return search(problem, model, {}, [](const std::string&) {});
}

class NotWhite : public testing::TestWithParam<NoiseCase> {};

TEST_P(NotWhite, IsNamed) {
  const NoiseCase& c = GetParam();
  const Model truth = noise_model(c.base + ", " + c.noise), nominal = noise_model(c.base);
  const auto problem = noise_set(c, truth);
  const SearchResult result = searched_for_noise(*problem, nominal);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, c.name());
  EXPECT_EQ(result.verdict, "missing_effect");
  EXPECT_TRUE(result.remaining.empty());
  // It has a name, and no formula is written in its place.
  EXPECT_EQ(noises_found(result), std::vector<std::string>{c.name()});
  EXPECT_FALSE(result.suggestion);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.12);
  const Assessment& best = result.best.assessment;
  for (size_t k = 0; k < best.unknowns.size(); ++k) {
    const Unknown& unknown = best.unknowns[k];
    const double expected = truth.find(unknown.effect)->parameters[unknown.parameter].value;
    EXPECT_NEAR(best.fit.value[k], expected, 4 * best.fit.sigma[k]) << unknown.parameter;
    EXPECT_LT(best.fit.sigma[k], expected) << unknown.parameter;
  }
}

TEST_P(NotWhite, IsNoAlarmWhereTheModelHasIt) {
  const NoiseCase& c = GetParam();
  const Model truth = noise_model(c.base + ", " + c.noise);
  const auto problem = noise_set(c, truth);
  const Score score = problem->score(truth, problem->all_groups());
  EXPECT_NEAR(score.error(), 1, 0.1);
  const SearchResult result = searched_for_noise(*problem, truth);
  EXPECT_EQ(result.verdict, "adequate");
  EXPECT_TRUE(result.outliers.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Effects, NotWhite,
    testing::Values(
        NoiseCase{"landmarks", "ideal_detector: {}", "range_wander: {sigma_m: 0.06, tau_s: 1.5}"},
        NoiseCase{"landmarks", "ideal_detector: {}",
                  "bearing_wander: {sigma_rad: 0.012, tau_s: 1.5}"},
        NoiseCase{"landmarks", "ideal_detector: {}",
                  "heading_wander: {sigma_rad: 0.024, tau_s: 2.3}"},
        NoiseCase{"landmarks", "ideal_detector: {}",
                  "landmark_bias: {range_sigma_m: 0.06, bearing_sigma_rad: 0.012}"},
        NoiseCase{"landmarks", "ideal_detector: {}", "range_tail: {fraction: 0.1, scale_m: 0.1}"},
        NoiseCase{"joints", "ideal_servo: {}", "joint_wander: {sigma_rad: 0.0012, tau_s: 0.1}"},
        NoiseCase{"odometry", "ideal_odometry: {}",
                  "pose_noise: {xy_sigma_m: 0.002, theta_sigma_rad: 0.003, per_mps: 4, per_radps: "
                  "1}"},
        NoiseCase{"points", "pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}",
                  "point_scatter: {fraction: 0.1, sigma_px: 0.4}"}),
    [](const auto& info) { return info.param.name(); });

}  // namespace
}  // namespace seam::measurement
