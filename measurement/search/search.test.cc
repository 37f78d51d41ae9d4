// The search finds what was hidden, and nothing where nothing was.
#include "measurement/search/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/problem/made_problem.h"
#include "measurement/search/choice.h"
#include "measurement/search/exchanges.h"
#include "measurement/study/study.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: " + effects + "\n", "test.yaml"));
}

std::filesystem::path landmark_protocol(const std::string& name, double first_time_s,
                                        int runs = 8) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / name;
  std::filesystem::create_directories(folder);
  write_landmark_walks(folder, runs, first_time_s);
  return folder;
}

SearchResult found_in(const std::string& truth, const std::string& name, double first_time_s = 0,
                      int runs = 8) {
  const auto protocol = landmark_protocol(name + "-protocol", first_time_s, runs);
  const auto out = std::filesystem::path(testing::TempDir()) / name;
  measure_set(model_of(truth), MeasurementSet::open(protocol), {.seed = 7, .out = out});
  const auto problem = open_problem(out);
  return search(*problem, model_of("{ideal_detector: {}}"), {}, [](const std::string&) {});
}

TEST(Search, CallsAnAdequateModelAdequate) {
  const SearchResult result = found_in("{ideal_detector: {}}", "landmarks-none");
  EXPECT_EQ(result.verdict, "adequate");
  EXPECT_TRUE(result.steps.empty());
  EXPECT_NEAR(result.base.assessment.error, 1.0, 0.12);
}

TEST(Search, FindsTwoEffectsAtOnce) {
  const SearchResult result = found_in(
      "{ideal_detector: {}, range_scale: {scale: 0.06}, mount_misalignment: {yaw_rad: -0.02}}",
      "landmarks-two");
  EXPECT_EQ(result.verdict, "missing_effect");
  ASSERT_EQ(result.steps.size(), 2u);
  EXPECT_NE(result.best.assessment.model.find("range_scale"), nullptr);
  ASSERT_NE(result.best.assessment.model.find("mount_misalignment"), nullptr);
  EXPECT_NEAR(result.best.assessment.model.find("range_scale")->value("scale"), 0.06, 0.004);
  EXPECT_NEAR(result.best.assessment.model.find("mount_misalignment")->value("yaw_rad"), -0.02,
              0.002);
  EXPECT_NEAR(result.best.assessment.error, 1.0, 0.12);
  // Both come first, and what seemed to help alone says what it stands in for.
  const auto& candidates = result.first.candidates;
  ASSERT_GT(candidates.size(), 2u);
  for (size_t i = 0; i < candidates.size(); ++i) {
    EXPECT_EQ(candidates[i].found, i < 2) << candidates[i].effect->name;
    if (i < 2) {
      EXPECT_EQ(candidates[i].effect->name, result.steps[i].effect);
    }
    EXPECT_EQ(candidates[i].stands_in_for.empty(), i < 2 || !candidates[i].significant);
  }
}

// Seconds since an epoch: a latency of milliseconds survives.
TEST(Search, KeepsThePrecisionOfEpochTimes) {
  const SearchResult result = found_in("{ideal_detector: {}, frame_latency: {latency_s: 0.03}}",
                                       "landmarks-epoch", 1248272278.25);
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "frame_latency");
  EXPECT_NEAR(result.best.assessment.model.find("frame_latency")->value("latency_s"), 0.03, 0.004);
}

// A single walk is both what is fitted and what is held out, and counts once: else chance would
// look twice as sure.
TEST(Search, OneGroupCountsOnce) {
  const auto protocol = landmark_protocol("landmarks-one-protocol", 0, 1);
  const auto out = std::filesystem::path(testing::TempDir()) / "landmarks-one";
  const Model model = model_of("{ideal_detector: {}}");
  measure_set(model, MeasurementSet::open(protocol), {.seed = 3, .out = out});
  const auto problem = open_problem(out);
  ASSERT_EQ(problem->facts().groups.size(), 1u);
  const double likelihood = problem->score(model, problem->all_groups()).log_likelihood;
  EXPECT_NEAR(assess_fixed(*problem, model).total_ll, likelihood, 1e-9 * std::abs(likelihood));
}

TEST(Search, FindsAnEffectInOneGroup) {
  const SearchResult result =
      found_in("{ideal_detector: {}, range_scale: {scale: 0.06}}", "landmarks-one-scale", 0, 1);
  EXPECT_EQ(result.verdict, "missing_effect");
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "range_scale");
}

// Beside something that no effect explains, so that the error stays far above the noise. A noise
// as wide as what is left would hide that, and is no step.
TEST(Search, FewGroupsAddWhatHalvesTheError) {
  for (const int runs : {1, 2, 4, 6}) {
    const SearchResult result = found_in(
        "{ideal_detector: {}, range_scale: {scale: 0.6}, wave: {stage: detector, "
        "range: \"range + k * sin(6 * range)\", bearing: \"bearing\", "
        "parameters: {k: {value: 0.2, neutral: 0, min: -1, max: 1}}}}",
        "landmarks-few", 0, runs);
    EXPECT_EQ(result.verdict, "unexplained_structure") << runs;
    ASSERT_FALSE(result.steps.empty()) << runs;
    EXPECT_EQ(result.steps[0].effect, "range_scale") << runs;
    EXPECT_LT(result.steps[0].error_after, 0.5 * result.steps[0].error_before) << runs;
    EXPECT_GT(result.best.assessment.error, kMisfit) << runs;
  }
}

// What few groups say of a look decides what all rows are asked, and nothing else: what leads is
// the same to the last digit, and what stays behind would have stayed there.
TEST(Search, AsksAllRowsOfWhatLeads) {
  const auto protocol = landmark_protocol("landmarks-many-protocol", 0, 260);
  const auto out = std::filesystem::path(testing::TempDir()) / "landmarks-many";
  const Model nominal = model_of("{ideal_detector: {}}");
  measure_set(model_of("{ideal_detector: {}, range_scale: {scale: 0.01}, "
                       "heading_wander: {sigma_rad: 0.006, tau_s: 1}}"),
              MeasurementSet::open(protocol), {.seed = 3, .out = out});
  const auto problem = open_problem(out);
  const Grown base{.assessment = assess(*problem, nominal, {})};
  EffectList effects;
  for (const char* name : {"range_scale", "range_offset", "bearing_scale", "frame_latency",
                           "clock_drift", "bearing_noise", "range_tail"})
    effects.push_back(effects::find_effect(name));
  const auto looks = [&](Asked asked) {
    return look_at(*problem, base, effects, kMaterial, /*promising_only=*/false, asked);
  };
  const Looks of_all = looks(Asked::all_rows);
  Looks led = looks(Asked::few_first);
  const Candidate* chosen = choose_by_all_rows(*problem, base, kMaterial, led);
  ASSERT_NE(chosen, nullptr);
  EXPECT_FALSE(chosen->of_few);
  EXPECT_EQ(led.tried, of_all.tried);
  ASSERT_EQ(led.candidates.size(), of_all.candidates.size());
  EXPECT_TRUE(led.candidates.front().significant);
  size_t stayed = 0;
  for (const Candidate& few : led.candidates) {
    const auto whole =
        std::find_if(of_all.candidates.begin(), of_all.candidates.end(),
                     [&](const Candidate& c) { return c.effect->name == few.effect->name; });
    ASSERT_NE(whole, of_all.candidates.end());
    EXPECT_EQ(few.significant, whole->significant) << few.effect->name;
    if (!few.of_few) {
      EXPECT_EQ(few.grown.assessment.total_ll, whole->grown.assessment.total_ll);
      continue;
    }
    ++stayed;
    EXPECT_LE(whole->grown.assessment.total_ll, few.most_ll) << few.effect->name;
    const double away =
        std::abs(whole->grown.assessment.total_ll - chosen->grown.assessment.total_ll);
    EXPECT_TRUE(!whole->significant || away > kTieReach * tie_width(whole->grown.assessment.error));
  }
  std::vector<Candidate> candidates = of_all.candidates;
  EXPECT_EQ(chosen->effect->name, choose(*problem, base, candidates)->effect->name);
  EXPECT_GE(stayed, 3u);
}

TEST(Landmarks, UnknownLandmarkIsNamed) {
  const auto folder = landmark_protocol("landmarks-unknown", 0);
  write_file_atomically(folder / "observations.csv",
                        "run,time_s,landmark,range_m,bearing_rad\n0,1.0,99,1.0,0.1\n");
  try {
    open_problem(folder);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("observations.csv:2: column landmark: found '99'"),
              std::string::npos)
        << error.what();
  }
}

// Each group lies anywhere, and within it y rises with x.
class Shifted : public MadeProblem {
 public:
  static constexpr double kNoise = 0.5, kShift = 50, kSlope = 0.9;
  static constexpr size_t kRows = 2000, kGroups = 20;

  Shifted()
      : MadeProblem(evenly(-1, 1, kRows), kNoise, [](const std::vector<double>& p, double x) {
          return p[0] + (p.size() > 1 ? p[1] * x : 0);
        }) {
    deal_into(kGroups);
    facts_.covariates = {{.name = "x", .values = x()}};
    std::vector<double> y;
    for (size_t i = 0; i < kRows; ++i) {
      y.push_back(kShift * normal({1, 1}, i % kGroups) + kSlope * x()[i] +
                  kNoise * normal({1, 2}, i));
    }
    take(std::move(y));
    prepare(flat());
  }

  static Model flat() {
    return made_model(made_effect("line", {{.name = "level", .min = -1, .max = 1}}), {0});
  }
  static EffectList effects() {
    return {made_effect("slope", {{.name = "size", .min = -100, .max = 100, .scale = 1}}),
            made_effect("shift",
                        {{.name = "group", .min = 0, .max = 1000, .scale = 10},
                         {.name = "row", .min = 0, .max = 10, .scale = 1}},
                        /*spread_only=*/true)};
  }

  // Of a group's n rows with variance v whose common shift has variance s the mean has v + n s.
  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* near = nullptr) const override {
    Evaluation out = MadeProblem::evaluate(model, groups, near);
    const auto* shift = model.find("shift");
    const double group = shift ? shift->values()[0] : 0, row = shift ? shift->values()[1] : 0;
    const double n = static_cast<double>(kRows) / kGroups, v = kNoise * kNoise + row * row;
    const double of_mean = v + n * group * group;
    for (size_t g = 0; g < kGroups; ++g) {
      double mean = 0;
      for (size_t i = g; i < kRows; i += kGroups) mean += out.residual[i] / n;
      for (size_t i = g; i < kRows; i += kGroups) {
        out.sigma[i] = std::sqrt(v);
        if (out.used[i])
          out.whitened[i] = (out.residual[i] - mean) / std::sqrt(v) + mean / std::sqrt(of_mean);
      }
      out.log_det[g] = groups[g] ? (n - 1) * std::log(v) + std::log(of_mean) : 0;
    }
    return out;
  }
  bool acts(const EffectDefinition& effect) const override {
    return effect.name == "slope" || effect.name == "shift";
  }
  std::vector<std::vector<double>> starts(const Model&,
                                          const EffectDefinition& effect) const override {
    if (effect.spread_only) return {{10, 1}};
    return {{0.1}};
  }
};

// Under groups that are shifted by a hundred noises the slope says nothing, and a spread of the
// rows would call it noise: both are found where one is tried beside the other.
TEST(Search, AMeanThatHelpsOnlyBesideASpreadIsFoundWithIt) {
  Shifted problem;
  const SearchResult result =
      search(problem, Shifted::flat(), Shifted::effects(), [](const std::string&) {});
  EXPECT_EQ(result.verdict, "missing_effect");
  EXPECT_TRUE(result.remaining.empty());
  const Model& found = result.best.assessment.model;
  ASSERT_TRUE(found.has("slope"));
  ASSERT_TRUE(found.has("shift"));
  EXPECT_NEAR(found.find("slope")->values()[0], Shifted::kSlope, 0.06);
  EXPECT_NEAR(found.find("shift")->values()[0], Shifted::kShift, 25);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.05);
}

// Effects whose images are waves along the rows of each group, at unit noise. The right lens with
// what it needs leaves nothing. The wrong one is off by a wave for which what was added beside it
// makes up, best where groups are held out.
class Waves : public MadeProblem {
 public:
  static constexpr size_t kGroups = 10, kRows = 40 * kGroups;
  using Values = std::vector<std::pair<std::string, double>>;

  explicit Waves(const Values& truth) : MadeProblem(evenly(0, 1, kRows), 1, nullptr) {
    deal_into(kGroups);
    held_ = folds().front();
    std::vector<double> y;
    for (size_t i = 0; i < kRows; ++i) {
      y.push_back(normal({3, 4}, i));
      for (const auto& [name, value] : truth) y.back() += value * image(name, i);
    }
    take(std::move(y));
    prepare(Model());
  }

  static std::shared_ptr<const EffectDefinition> effect(const std::string& name) {
    if (auto found = effects::find_effect(name)) return found;
    return made_effect(name, {{.name = "size", .min = -100, .max = 100, .scale = 1}});
  }
  // A model of these, fitted, `given` not by a search.
  Grown fitted(const std::vector<std::string>& names, const std::string& given = "") const {
    Grown grown;
    std::vector<Unknown> unknowns;
    for (const std::string& name : names) {
      if (name != given) grown.added.push_back(name);
      grown.assessment.model.add_neutral(effect(name));
      unknowns.push_back({name, 0});
    }
    grown.assessment = assess(*this, grown.assessment.model, unknowns);
    return grown;
  }

  Evaluation evaluate(const Model& model, const Groups& groups,
                      const Evaluation* = nullptr) const override {
    Evaluation out;
    out.sigma.assign(kRows, 1);
    for (size_t i = 0; i < kRows; ++i) {
      double mean = 0;
      for (const auto& each : model.effects())
        mean += each.values()[0] * image(each.definition->name, i);
      out.residual.push_back(y()[i] - mean);
    }
    whiten_diagonal(*this, groups, out);
    return out;
  }
  bool acts(const EffectDefinition& effect) const override {
    return effect.name == "radial_distortion" || effect.name == "fisheye";
  }
  bool is_smooth(const Model&) const override { return true; }

 private:
  double image(const std::string& effect, size_t i) const {
    const bool held = held_[static_cast<size_t>(facts_.group_of_row[i])];
    const auto wave = [&](int k) {
      return std::sqrt(2) * std::sin(k * 0.157 * (static_cast<double>(i / kGroups) + 0.5));
    };
    if (effect.starts_with("radial_distortion")) return 30 * wave(1);
    if (effect == "fisheye") return 30 * wave(1) + (held ? -28 * wave(4) : 30 * wave(3));
    if (effect == "makes_up") return 2 * wave(2) + (held ? 2 * wave(4) : -wave(3));
    if (effect == "needed") return 2 * wave(2);
    return wave(5);
  }

  Groups held_;
};

const Waves::Values kRightLens = {{"radial_distortion", 0.1}, {"needed", 1}};

// Each would be fitted in full, and come to nothing.
TEST(Exchanges, WhatIsNoExchangeOfTwoIsNotFitted) {
  const Waves problem(kRightLens);
  const Exchanges exchanges(problem);
  const auto in_the_place_of = [&](const Grown& grown, const std::string& out,
                                   const std::string& in) {
    return exchanges.with_other(grown, out, Waves::effect(in)).has_value();
  };
  const Grown right = problem.fitted({"radial_distortion", "needed"});
  EXPECT_TRUE(in_the_place_of(right, "needed", "makes_up"));
  EXPECT_FALSE(in_the_place_of(right, "needed", "fisheye"));  // It pushes out the lens, too.
  const Grown left = problem.fitted({"radial_distortion@left", "needed"});
  EXPECT_TRUE(in_the_place_of(left, "radial_distortion@left", "radial_distortion"));
  EXPECT_FALSE(in_the_place_of(left, "radial_distortion@left", "radial_distortion@right"));
}

}  // namespace
}  // namespace seam::measurement
