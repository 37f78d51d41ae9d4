// Sets of outcomes with runs that are calculated by hand: a level camera looks at a ball from many
// places and measures its distance and bearing from the ideal pinhole, with noise by seed. The
// whole simulator: tests/outcomes_test.py.
#include "measurement/kinds/outcomes/outcomes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "effects/registry.h"
#include "effects/stages/geometry.h"
#include "measurement/kinds/outcomes/outcomes_testing.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using effects::Model;
using testing::HasSubstr;

constexpr double kHeight_m = 0.2, kRadius_m = 0.0425, kFocus_px = 160, kMiddle_u = 88,
                 kMiddle_v = 72;
constexpr size_t kPlaces = 12, kAlike = 4;

Model camera() {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\nname: camera\neffects:\n"
                            "  pinhole: {fx_px: 160, fy_px: 160, cx_px: 88, cy_px: 72}\n",
                            "camera.yaml"));
}

// A ball on the ground, at places that differ by scenario.
class BallRuns final : public RunMaker {
 public:
  explicit BallRuns(size_t scenarios) : scenarios_(scenarios) {}
  std::vector<std::string> columns(size_t) const override {
    return {"distance_error_m", "bearing_error_rad", "width_error_px"};
  }
  uint64_t runs(size_t) const override { return kPlaces * kAlike; }
  uint64_t alike(size_t) const override { return kAlike; }
  std::map<std::string, std::string> files(size_t) const override { return {}; }
  RunTable make(size_t scenario, const Model& model, uint64_t draw) override {
    EXPECT_LT(scenario, scenarios_);
    const effects::Projection projection(model, 176, 144);
    const Pose X_LC = effects::mount_of(model);
    RunTable table;
    for (size_t run = 0; run < kPlaces * kAlike; ++run) {
      const size_t place = run / kAlike;
      const double ahead_m =
          0.4 + 0.35 * static_cast<double>(scenario) + 0.05 * static_cast<double>(place % 5);
      const double left_m = (static_cast<double>(place) / (kPlaces - 1) - 0.5) * 0.8 * ahead_m;
      const RandomStream noise =
          RandomStream{.seed = draw}.child(scenario).child("ball").child(run);
      table.runs.push_back(
          measured(projection, X_LC, {ahead_m, left_m, -kHeight_m}, noise_px(model), noise));
    }
    return table;
  }

 private:
  static double noise_px(const Model& model) {
    const effects::ModelEffect* read_noise = model.find("read_noise");
    return read_noise == nullptr ? 0.3 : std::hypot(0.3, 0.2 * read_noise->parameters[0].value);
  }
  static std::vector<double> measured(const effects::Projection& projection, const Pose& X_LC,
                                      const Vec3& p_L, double noise_px, RandomStream noise) {
    const Vec3 p_C = X_LC.inverse() * p_L;
    const effects::ImagePoint image = projection.project(p_C);
    const effects::ImagePoint rim = projection.project(p_C + Vec3(kRadius_m, 0, 0));
    if (!image.visible || !rim.visible) return {std::nan(""), std::nan(""), std::nan("")};
    const double u = image.u + noise_px * normal(noise, 0);
    const double v = image.v + noise_px * normal(noise, 1);
    const double ahead_m = kHeight_m * kFocus_px / (v - kMiddle_v);
    const double left_m = -ahead_m * (u - kMiddle_u) / kFocus_px;
    return {std::hypot(ahead_m, left_m) - std::hypot(p_L.x, p_L.y),
            std::atan2(left_m, ahead_m) - std::atan2(p_L.y, p_L.x),
            rim.u - image.u - kFocus_px * kRadius_m / p_L.x + noise_px * normal(noise, 2)};
  }
  size_t scenarios_;
};

class Outcomes : public testing::Test {
 protected:
  void SetUp() override {
    instruments_.runs = [](const RunSpec& spec) -> std::unique_ptr<RunMaker> {
      return std::make_unique<BallRuns>(spec.plans.size());
    };
    folder_ = testing::TempDir() + "/outcomes_" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    std::string scenarios, rows = "scenario,value,statistic,measured,sigma\n";
    for (const char* name : {"near", "middle", "far", "farthest"}) {
      scenarios += fmt::format("{}{}: {}.yaml", scenarios.empty() ? "" : ", ", name, name);
      write(fmt::format("{}.yaml", name), "");
      for (const char* value : {"distance_error_m", "bearing_error_rad", "width_error_px"}) {
        for (const char* statistic : {"mean", "spread", "largest"})
          rows += fmt::format("{},{},{},0,1\n", name, value, statistic);
      }
    }
    write("measurement.yaml", head(scenarios));
    write("outcomes.csv", rows);
  }
  static std::string head(const std::string& scenarios) {
    return fmt::format(
        "format: seam-measurement/1\nkind: outcomes\nfiles: {{outcomes: outcomes.csv}}\n"
        "scenarios: {{{}}}\ncandidates: {{focal_length_error: , principal_point_offset: , "
        "mount_misalignment: , mount_offset: , radial_distortion: , tangential_distortion: }}\n",
        scenarios);
  }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ + "/" + name) << text;
  }
  std::string made(const Model& truth, uint64_t seed) {
    const std::string out = folder_ + "/made";
    std::filesystem::remove_all(out);
    std::filesystem::create_directories(out);
    measure_outcomes(truth, MeasurementSet::open(folder_), {.seed = seed, .out = out},
                     instruments_);
    return out;
  }
  SearchResult searched(const std::string& set) {
    OutcomesProblem problem(MeasurementSet::open(set), instruments_);
    problem.prepare(camera());
    return search(problem, camera(), {}, [](const std::string&) {});
  }
  std::string why_refused() {
    try {
      OutcomesProblem problem(MeasurementSet::open(folder_), instruments_);
      problem.prepare(camera());
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  Instruments instruments_;
  std::string folder_;
};

Model with(const std::string& effect, size_t parameter, double value) {
  Model model = camera();
  model.add_neutral(effects::find_effect(effect));
  model.set_value(effect, parameter, value);
  return model;
}

// Each of these changes some statistic by about five of its standard errors.
struct Hidden {
  const char* effect;
  size_t parameter;
  double value;
};
constexpr Hidden kHidden[] = {
    {"focal_length_error", 0, 0.02},      {"focal_length_error", 1, -0.01},
    {"focal_length_error", 1, 0.012},     {"principal_point_offset", 0, 0.5},
    {"principal_point_offset", 1, -0.5},  {"mount_misalignment", 0, 0.004},
    {"mount_misalignment", 1, 0.003},     {"mount_misalignment", 2, 0.02},
    {"mount_offset", 0, 0.012},           {"mount_offset", 1, 0.004},
    {"mount_offset", 2, -0.003},          {"radial_distortion", 0, -0.05},
    {"radial_distortion", 0, 0.06},       {"tangential_distortion", 0, 0.01},
    {"tangential_distortion", 1, -0.008}, {"mount_offset", 2, 0.004},
};

TEST_F(Outcomes, HiddenEffectIsFirstOrTied) {
  size_t right = 0;
  for (size_t i = 0; i < std::size(kHidden); ++i) {
    const Hidden& hidden = kHidden[i];
    const SearchResult result =
        searched(made(with(hidden.effect, hidden.parameter, hidden.value), i));
    const bool found = is_named(result, hidden.effect);
    right += found;
    std::string told = fmt::format("{} {} = {}: error {:.2f} ->", hidden.effect, hidden.parameter,
                                   hidden.value, result.base.assessment.error);
    for (const Candidate& candidate : result.first.candidates) {
      if (!candidate.significant) continue;
      told += fmt::format(" {} ({:.1f}, {:.2f})", candidate.effect->name, candidate.total_gain_ll,
                          candidate.grown.assessment.error);
    }
    if (!found) std::printf("%s\n", told.c_str());
  }
  EXPECT_GE(right, 15u);
}

TEST_F(Outcomes, ErrorsAreThoseOfOtherRuns) {
  double square = 0;
  constexpr int kSets = 30;
  for (uint64_t seed = 200; seed < 200 + kSets; ++seed) {
    OutcomesProblem problem(MeasurementSet::open(made(camera(), seed)), instruments_);
    problem.prepare(camera());
    const Score score = problem.score(camera(), problem.all_groups());
    square += score.chi2 / static_cast<double>(score.n) / kSets;
  }
  EXPECT_GT(square, 0.75);
  EXPECT_LT(square, 1.25);
}

TEST_F(Outcomes, NothingHiddenNothingFound) {
  for (uint64_t seed = 100; seed < 120; ++seed) {
    const SearchResult result = searched(made(camera(), seed));
    EXPECT_TRUE(result.steps.empty()) << seed << ": " << result.steps.front().effect;
    EXPECT_LT(result.base.assessment.error, 1.6) << seed;
    EXPECT_GT(result.base.assessment.error, 0.5) << seed;
  }
}

TEST_F(Outcomes, EstimatesLieWithinTheirErrors) {
  constexpr double kTruth = 0.012;
  double square = 0;
  constexpr int kSets = 20;
  for (uint64_t seed = 0; seed < kSets; ++seed) {
    OutcomesProblem problem(MeasurementSet::open(made(with("focal_length_error", 1, kTruth), seed)),
                            instruments_);
    problem.prepare(camera());
    const Fit fit = problem.fit(with("focal_length_error", 1, 0.001), {{"focal_length_error", 1}},
                                problem.all_groups());
    square += std::pow((fit.value[0] - kTruth) / fit.sigma[0], 2) / kSets;
  }
  EXPECT_GT(square, 0.4);
  EXPECT_LT(square, 2);
}

TEST_F(Outcomes, NoisesAreFoundByHowStatisticsScatter) {
  constexpr double kTruth_dn = 2;  // Two thirds more scatter.
  std::string text = read_file(folder_ + "/measurement.yaml");
  text.replace(text.find("candidates: {"), 13, "candidates: {read_noise: , ");
  write("measurement.yaml", text);
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const SearchResult result = searched(made(with("read_noise", 0, kTruth_dn), seed));
    ASSERT_TRUE(is_named(result, "read_noise")) << seed;
    const effects::ModelEffect* found = result.best.assessment.model.find("read_noise");
    ASSERT_NE(found, nullptr);
    EXPECT_NEAR(found->parameters[0].value, kTruth_dn, 0.5) << seed;
  }
  for (uint64_t seed = 4; seed < 12; ++seed)
    EXPECT_FALSE(is_named(searched(made(camera(), seed)), "read_noise")) << seed;
}

TEST_F(Outcomes, NoisesThatNobodyNamedAreTriedWhereTheyShow) {
  const auto tries_noise = [&](const std::string& statistic) {
    write("outcomes.csv",
          "scenario,value,statistic,measured,sigma\nnear,width_error_px," + statistic + ",1,1\n");
    std::string text = read_file(folder_ + "/measurement.yaml");
    if (const size_t at = text.find("candidates"); at != std::string::npos) text.resize(at);
    write("measurement.yaml", text);
    const OutcomesProblem problem(MeasurementSet::open(folder_), instruments_);
    return problem.acts(*effects::find_effect("read_noise"));
  };
  EXPECT_FALSE(tries_noise("mean"));
  EXPECT_TRUE(tries_noise("spread"));
  EXPECT_TRUE(tries_noise("rate"));
}

TEST_F(Outcomes, WhatIsReadOffHasItsOwnError) {
  write("outcomes.csv",
        "scenario,value,statistic,measured,sigma,reading_sigma\n"
        "near,width_error_px,mean,,,5\nnear,width_error_px,spread,,,\n");
  double square = 0;
  constexpr int kSets = 40;
  for (uint64_t seed = 0; seed < kSets; ++seed) {
    const CsvTable table = MeasurementSet::open(made(camera(), seed)).table("outcomes");
    EXPECT_NEAR(table.numbers("sigma")[0], 5, 0.1);
    EXPECT_LT(table.numbers("sigma")[1], 0.2);
    square += std::pow(table.numbers("measured")[0] / 5, 2) / kSets;
  }
  EXPECT_NEAR(square, 1, 0.6);
}

TEST_F(Outcomes, BudgetIsKept) {
  const std::string set = made(with("mount_misalignment", 0, 0.004), 1);
  std::ofstream(set + "/measurement.yaml", std::ios::app) << "most_runs: 1000\n";
  OutcomesProblem problem(MeasurementSet::open(set), instruments_);
  problem.prepare(camera());
  search(problem, camera(), {}, [](const std::string&) {});
  const std::vector<std::string> said = problem.remarks(camera());
  ASSERT_EQ(said.size(), 2u);
  EXPECT_THAT(said[0], HasSubstr("960 runs were made, of at most 1000"));
  EXPECT_THAT(said[1], HasSubstr("budget"));
}

TEST_F(Outcomes, BadSetsAreToldWithTheirPlace) {
  const std::string head_row = "scenario,value,statistic,measured,sigma\n";
  write("outcomes.csv", head_row + "nera,distance_error_m,mean,1,1\n");
  EXPECT_THAT(why_refused(), HasSubstr("outcomes.csv:2: column scenario"));
  EXPECT_THAT(why_refused(), HasSubstr("did you mean 'near'?"));
  write("outcomes.csv", head_row + "near,distance_eror_m,mean,1,1\n");
  EXPECT_THAT(why_refused(), HasSubstr("outcomes.csv:2: column value"));
  write("outcomes.csv", head_row + "near,distance_error_m,quantile_1.5,1,1\n");
  EXPECT_THAT(why_refused(), HasSubstr("outcomes.csv:2: column statistic"));
  write("outcomes.csv", head_row + "near,distance_error_m,mean,1,0\n");
  EXPECT_THAT(why_refused(), HasSubstr("outcomes.csv:2: column sigma"));
  write("outcomes.csv",
        "scenario,value,statistic,measured,sigma,reading_sigma\n"
        "near,distance_error_m,mean,1,1,-2\n");
  EXPECT_THAT(why_refused(), HasSubstr("outcomes.csv:2: column reading_sigma"));
  write("outcomes.csv", head_row);
  EXPECT_THAT(why_refused(), HasSubstr("no rows"));
}

}  // namespace
}  // namespace seam::measurement
