// Sets of outcomes as few runs of a simulator give them: four runs a scenario that scatter by where
// the robot came to stand, pixels that make staircases of what is measured, and effects that one
// scenario alone shows. The whole simulator: scripts/hidden_outcomes.py.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "effects/registry.h"
#include "effects/stages/geometry.h"
#include "effects/stages/walk/locomotion.h"
#include "measurement/kinds/outcomes/outcomes.h"
#include "measurement/kinds/outcomes/outcomes_testing.h"
#include "sim_core/base/random.h"

namespace seam::measurement::few_runs {
namespace {

using effects::Model;

constexpr double kHeight_m = 0.2, kRadius_m = 0.0425, kFocus_px = 160, kMiddle_u = 88,
                 kMiddle_v = 72, kPixel_px = 0.25;
constexpr size_t kRuns = 4;
constexpr const char* kPlan = "seeds: [1, 4]\n";
constexpr const char* kScenarios[] = {"near", "far", "swing", "walk"};

Model camera() {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\nname: camera\neffects:\n"
                            "  pinhole: {fx_px: 160, fy_px: 160, cx_px: 88, cy_px: 72}\n",
                            "camera.yaml"));
}

double value_of(const Model& model, const char* effect, const char* parameter) {
  const effects::ModelEffect* found = model.find(effect);
  for (size_t i = 0; found != nullptr && i < found->parameters.size(); ++i) {
    if (found->definition->parameters[i].name == parameter) return found->parameters[i].value;
  }
  return effects::find_effect(effect)->parameters[0].neutral;
}

double on_pixels(double value_px) {
  return kPixel_px * std::round(value_px / kPixel_px);
}

// Near and far a ball is looked at; a swing ends at an angle that the encoder tells; a walk ends at
// a place that is measured. A response of its own changes what area a near ball seems to have.
class FewRuns final : public RunMaker {
 public:
  std::vector<std::string> columns(size_t) const override { return {"error_m", "side", "other"}; }
  uint64_t runs(size_t) const override { return kRuns; }
  uint64_t alike(size_t) const override { return kRuns; }
  std::map<std::string, std::string> files(size_t plan) const override {
    return {{fmt::format("{}.yaml", kScenarios[plan]), kPlan}};
  }
  RunTable make(size_t scenario, const Model& model, uint64_t draw) override {
    RunTable table;
    for (size_t run = 0; run < kRuns; ++run) {
      const RandomStream noise = RandomStream{.seed = draw}.child(scenario).child(run);
      table.runs.push_back(one_run(scenario, model, noise));
    }
    return table;
  }

 private:
  static std::vector<double> one_run(size_t scenario, const Model& model, RandomStream noise) {
    const effects::Projection projection(model, 176, 144);
    const double walks_m = scenario == 3 ? 0.28 : 0.05;
    const double faster = 1 + effects::locomotion_of(model).vx_scale;
    const double scatter_m = 0.03 * std::sqrt(walks_m);
    const double ahead_m =
                     (scenario == 0 ? 0.55 : 0.9) - walks_m * faster + scatter_m * normal(noise, 0),
                 left_m = 0.05 + scatter_m * normal(noise, 1);
    const Vec3 p_C = effects::mount_of(model).inverse() * Vec3(ahead_m, left_m, -kHeight_m);
    const effects::ImagePoint image = projection.project(p_C);
    const effects::ImagePoint rim = projection.project(p_C + Vec3(kRadius_m, 0, 0));
    if (!image.visible || !rim.visible) return {std::nan(""), std::nan(""), std::nan("")};
    const double v = on_pixels(image.v), u = on_pixels(image.u);
    const double seen_m = kHeight_m * kFocus_px / (v - kMiddle_v);
    const double side = -seen_m * (u - kMiddle_u) / kFocus_px;
    const double gamma = value_of(model, "response_gamma", "gamma");
    const double width_px = on_pixels(rim.u - image.u - (scenario == 0 ? 3 * (gamma - 1) : 0));
    const double pan_rad = 0.2 * (1 + value_of(model, "encoder_scale", "pan_scale"));
    const double other = scenario == 2 ? 1e-3 * std::round(pan_rad / 1e-3) : width_px;
    return {seen_m - ahead_m - walks_m * (faster - 1), side, other};
  }
};

struct Hidden {
  const char* effect;
  size_t parameter;
  double value;
};
constexpr Hidden kHidden[] = {{"focal_length_error", 1, 0.02},  {"focal_length_error", 1, -0.02},
                              {"mount_misalignment", 1, 0.005}, {"mount_misalignment", 1, -0.005},
                              {"mount_offset", 2, 0.005},       {"mount_offset", 2, -0.005},
                              {"response_gamma", 0, 0.1},       {"response_gamma", 0, -0.1},
                              {"encoder_scale", 1, 0.02},       {"encoder_scale", 1, -0.02},
                              {"odometry_scale", 0, 0.1},       {"odometry_scale", 0, -0.1}};

class OutcomesOfFewRuns : public testing::Test {
 protected:
  void SetUp() override {
    instruments_.runs = [](const RunSpec&) { return std::make_unique<FewRuns>(); };
    folder_ = testing::TempDir() + "/few_runs_" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    std::string scenarios, rows = "scenario,value,statistic,measured,sigma\n";
    for (const char* name : kScenarios) {
      scenarios += fmt::format("{}{}: {}.yaml", scenarios.empty() ? "" : ", ", name, name);
      write(fmt::format("{}.yaml", name), kPlan);
      for (const char* value : {"error_m", "side", "other"})
        rows += fmt::format("{},{},mean,0,1\n", name, value);
    }
    write("measurement.yaml",
          fmt::format("format: seam-measurement/1\nkind: outcomes\nfiles: {{outcomes: "
                      "outcomes.csv}}\nscenarios: {{{}}}\ncandidates: {{focal_length_error: "
                      "{{fy_scale: [-0.2, 0.2]}}, mount_misalignment: {{pitch_rad: [-0.2, 0.2]}}, "
                      "mount_offset: {{z_m: [-0.1, 0.1]}}, response_gamma: , encoder_scale: "
                      "{{pan_scale: [-0.3, 0.3]}}, odometry_scale: {{vx_scale: [-0.5, 0.5]}}}}\n",
                      scenarios));
    write("outcomes.csv", rows);
  }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ + "/" + name) << text;
  }
  std::string made(const Model& truth, uint64_t seed, bool noise = true) {
    const std::string out = folder_ + "/made";
    std::filesystem::remove_all(out);
    std::filesystem::create_directories(out);
    measure_outcomes(truth, MeasurementSet::open(folder_),
                     {.seed = seed, .noise = noise, .out = out}, instruments_);
    return out;
  }
  CsvTable table(const Model& truth) {
    return MeasurementSet::open(made(truth, 0, /*noise=*/false)).table("outcomes");
  }
  // With this effect, of a size that changes the number that is changed most by so many errors.
  Model with(const Hidden& hidden, double sigmas) {
    const CsvTable plain = table(camera());
    const auto before = plain.numbers("measured"), sigma = plain.numbers("sigma");
    double by = hidden.value;
    for (int attempt = 0; attempt < 8; ++attempt) {
      const auto after = table(moved(hidden, by)).numbers("measured");
      double most = 0.1;
      for (size_t i = 0; i < after.size(); ++i)
        most = std::max(most, std::abs(after[i] - before[i]) / sigma[i]);
      if (std::abs(most - sigmas) < 0.1 * sigmas) break;
      by *= std::clamp(sigmas / most, 0.25, 4.0);
    }
    return moved(hidden, by);
  }
  static Model moved(const Hidden& hidden, double by) {
    Model model = camera();
    const auto effect = effects::find_effect(hidden.effect);
    model.add_neutral(effect);
    model.set_value(hidden.effect, hidden.parameter,
                    effect->parameters[hidden.parameter].neutral + by);
    return model;
  }
  SearchResult searched(const std::string& set) {
    OutcomesProblem problem(MeasurementSet::open(set), instruments_);
    problem.prepare(camera());
    return search(problem, camera(), {}, [](const std::string&) {});
  }

  Instruments instruments_;
  std::string folder_;
};

TEST_F(OutcomesOfFewRuns, HiddenEffectIsFirstOrTied) {
  size_t right = 0, all = 0;
  for (uint64_t seed = 0; seed < 5; ++seed) {
    for (const Hidden& hidden : kHidden) {
      const SearchResult result = searched(made(with(hidden, 5), seed));
      const bool found = is_named(result, hidden.effect);
      right += found, ++all;
      if (found) continue;
      std::string told = fmt::format("{} {}: error {:.2f} ->", hidden.effect, hidden.parameter,
                                     result.base.assessment.error);
      for (const Candidate& candidate : result.first.candidates)
        told += fmt::format(" {} ({:.1f}, p {:.1e}, {:.2f})", candidate.effect->name,
                            candidate.total_gain_ll, candidate.p_value,
                            candidate.grown.assessment.error);
      std::printf("%s\n", told.c_str());
    }
  }
  EXPECT_GE(10 * right, 9 * all) << right << " of " << all;
}

TEST_F(OutcomesOfFewRuns, NothingHiddenNothingFound) {
  constexpr int kSets = 40;
  size_t alarms = 0;
  double square = 0;
  for (uint64_t seed = 100; seed < 100 + kSets; ++seed) {
    const SearchResult result = searched(made(camera(), seed));
    alarms += !result.steps.empty();
    square += std::pow(result.base.assessment.error, 2) / kSets;
  }
  EXPECT_LE(alarms, 1u);
  EXPECT_GT(square, 0.7);
  EXPECT_LT(square, 1.4);
}

}  // namespace
}  // namespace seam::measurement::few_runs
