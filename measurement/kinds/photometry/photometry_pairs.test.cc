// Effects of photometry that are easily taken for each other: told apart where the data can,
// declared tied where they cannot.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

const std::string kSensor =
    "linear_response: {gain_dn: 220, black_dn: 16}, rolling_shutter: {line_delay_s: 0.0012}";
const std::string kNoise = kSensor + ", read_noise: {sigma_dn: 1.4}";

Model model_with(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "model"));
}

// What the search finds in flat fields of 24 x 18 made with `hidden` beside the nominal effects.
SearchResult found(const std::string& name, const std::string& nominal, const std::string& hidden,
                   const std::vector<double>& levels = {0, 0.1, 0.3, 0.6}, int frames_each = 8,
                   const std::vector<double>& exposures_s = {0.005}) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("pair-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "protocol");
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  int frame = 0;
  for (const double exposure_s : exposures_s) {
    for (const double light : levels) {
      for (int k = 0; k < frames_each; ++k, ++frame)
        table +=
            fmt::format("{0},{0}.png,{1:.6f},{2},{3}\n", frame, 0.041 * frame, exposure_s, light);
    }
  }
  write_file_atomically(folder / "protocol" / "frames.csv", table);
  write_file_atomically(folder / "protocol" / "measurement.yaml",
                        "format: seam-measurement/1\nkind: photometry\ntitle: pair\ncamera: "
                        "{width_px: 24, height_px: 18, "
                        "frame_period_s: 0.041}\ngroup: frame\nfiles: {frames: frames.csv}\n");
  measure_set(model_with(nominal + ", " + hidden), MeasurementSet::open(folder / "protocol"),
              {.seed = 5, .out = folder / "set"});
  const auto problem = open_problem(folder / "set");
  SearchResult result = search(*problem, model_with(nominal), {}, [](const std::string&) {});
  std::filesystem::remove_all(folder);
  return result;
}

std::string steps_of(const SearchResult& result) {
  std::string text;
  for (const Step& step : result.steps) text += step.effect + " ";
  return text;
}

TEST(PhotometryPairs, ToldApart) {
  struct Case {
    std::string effect, values, other;
  };
  const std::vector<Case> cases = {
      {"vignetting", "{a2: 0.05, a4: 0}", "uneven_lighting"},
      {"uneven_lighting", "{gx: 0.03, gy: -0.02}", "vignetting"},
      {"lamp_flicker", "{frequency_hz: 100, depth: 0.04, phase_rad: 1}", "row_noise"},
      {"row_noise", "{sigma_dn: 0.8}", "lamp_flicker"},
      {"pixel_gain_spread", "{sigma: 0.015}", "shot_noise"},
      {"shot_noise", "{electrons_per_dn: 25}", "pixel_gain_spread"},
      {"column_offsets", "{sigma_dn: 0.8}", "shot_noise"},
  };
  for (const Case& c : cases) {
    const SearchResult result = found(c.effect, kNoise, c.effect + ": " + c.values);
    ASSERT_EQ(result.steps.size(), 1u) << c.effect << " found as " << steps_of(result);
    const Candidate& first = result.first.candidates.front();
    EXPECT_EQ(first.effect->name, c.effect);
    EXPECT_EQ(result.steps[0].effect, c.effect);
    for (const auto& ties : {first.indistinguishable_from, result.steps[0].indistinguishable_from})
      EXPECT_EQ(std::count(ties.begin(), ties.end(), c.other), 0) << c.effect;
    EXPECT_NEAR(result.best.assessment.error, 1, 0.04) << c.effect;
  }
}

TEST(PhotometryPairs, BothAtOnceAreBothFound) {
  for (const auto& [a, b] :
       {std::pair("vignetting: {a2: 0.05, a4: 0}", "uneven_lighting: {gx: 0.03, gy: -0.02}"),
        std::pair("lamp_flicker: {frequency_hz: 100, depth: 0.04}", "row_noise: {sigma_dn: 0.8}"),
        std::pair("pixel_gain_spread: {sigma: 0.015}", "shot_noise: {electrons_per_dn: 25}"),
        std::pair("shot_noise: {electrons_per_dn: 25}", "column_offsets: {sigma_dn: 0.8}")}) {
    const SearchResult result = found("both", kNoise, std::string(a) + ", " + b);
    EXPECT_EQ(result.steps.size(), 2u) << a << " " << b << " found as " << steps_of(result);
    for (const Step& step : result.steps)
      EXPECT_TRUE(std::string(a).starts_with(step.effect) ||
                  std::string(b).starts_with(step.effect))
          << step.effect;
  }
}

// A bent response, and noises beside it: none of them grows to cover what the mean lacks, neither
// when it is added nor when another is added after it.
TEST(PhotometryPairs, NoSpreadCoversABentResponse) {
  const std::string free =
      "linear_response: {gain_dn: {value: 250, free: true}, black_dn: {value: 20, free: true}}, "
      "read_noise: {sigma_dn: {value: 0.5, free: true}}";
  const SearchResult result =
      found("bent", free,
            "row_noise: {sigma_dn: 4}, pixel_gain_spread: {sigma: 0.015}, shot_noise: "
            "{electrons_per_dn: 20}, response_cubic: {k2: -0.3, k3: 0}",
            {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}, 4);
  EXPECT_EQ(result.steps.size(), 4u) << steps_of(result);
  const Model& model = result.best.assessment.model;
  ASSERT_NE(model.find("row_noise"), nullptr) << steps_of(result);
  EXPECT_NEAR(model.find("row_noise")->value("sigma_dn"), 4, 0.4);
  EXPECT_NEAR(model.find("linear_response")->value("black_dn"), 20, 1);
}

// Rows that are off as a whole make a bend less certain, not smaller: it moves values by a third
// of their noise.
TEST(PhotometryPairs, ABendBesideRowNoiseMatters) {
  const std::string free =
      "linear_response: {gain_dn: {value: 200, free: true}, black_dn: {value: 20, free: true}}, "
      "read_noise: {sigma_dn: {value: 0.5, free: true}}";
  const SearchResult result =
      found("bent_rows", free, "row_noise: {sigma_dn: 6}, response_gamma: {gamma: 0.9}",
            {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}, 4);
  EXPECT_EQ(result.steps.size(), 2u) << steps_of(result);
  EXPECT_NE(result.best.assessment.model.find("response_gamma"), nullptr) << steps_of(result);
  EXPECT_NEAR(result.best.assessment.model.find("row_noise")->value("sigma_dn"), 6, 0.6);
}

// Where the light goes beyond what values can hold, few values of a level are not clipped: they
// make all of its variance, and must not count as if all values had told it.
TEST(PhotometryPairs, SeriesThatGoBeyondTheTopTellTheirNoises) {
  const std::string free =
      "linear_response: {gain_dn: {value: 200, free: true}, black_dn: {value: 20, free: true}}, "
      "read_noise: {sigma_dn: {value: 2, free: true}}";
  std::vector<double> levels = {0, 0};
  for (int i = 1; i <= 20; ++i) levels.push_back(0.06 * i);
  const SearchResult result =
      found("beyond", free, "pixel_gain_spread: {sigma: 0.02}, shot_noise: {electrons_per_dn: 5}",
            levels, 2);
  EXPECT_EQ(result.steps.size(), 2u) << steps_of(result);
  const Assessment& best = result.best.assessment;
  ASSERT_NE(best.model.find("pixel_gain_spread"), nullptr) << steps_of(result);
  ASSERT_NE(best.model.find("shot_noise"), nullptr) << steps_of(result);
  EXPECT_NEAR(best.model.find("pixel_gain_spread")->value("sigma"), 0.02, 0.002);
  EXPECT_NEAR(best.model.find("shot_noise")->value("electrons_per_dn"), 5, 0.25);
  EXPECT_NEAR(best.error, 1, 0.03);
}

// What a frame has in common gains as little likelihood as there are frames, and moves its values
// all the same: by as much as their rows' noise.
TEST(PhotometryPairs, AFluctuationBesideRowNoiseMatters) {
  const std::string free =
      "linear_response: {gain_dn: {value: 190, free: true}, black_dn: {value: 20, free: true}}, "
      "read_noise: {sigma_dn: {value: 2, free: true}}";
  const SearchResult result =
      found("lamp_rows", free,
            "row_noise: {sigma_dn: 2}, lamp_fluctuation: {sigma: 0.02}, shot_noise: "
            "{electrons_per_dn: 20}",
            {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9}, 4);
  EXPECT_EQ(result.steps.size(), 3u) << steps_of(result);
  EXPECT_NE(result.best.assessment.model.find("lamp_fluctuation"), nullptr) << steps_of(result);
}

// Photon noise says how many electrons make a DN, and with it what a dark current is that was
// counted in DN; a pattern of the dark is told beside one of the gain that leaves a hundred times
// as much.
TEST(PhotometryPairsSlow, DarkCurrentBesidePhotonNoise) {
  const std::string free =
      "linear_response: {gain_dn: {value: 50, free: true}, black_dn: {value: 16, free: true}}, "
      "read_noise: {sigma_dn: {value: 2, free: true}}";
  const SearchResult result =
      found("dark_current", free,
            "dark_current: {electrons_per_s: 4000}, shot_noise: {electrons_per_dn: 4}, "
            "pixel_gain_spread: {sigma: 0.08}, pixel_offset_spread: {sigma_dn: 1.5}",
            {0, 0.2, 0.4, 0.6, 0.8}, 4, {0.005, 0.01, 0.02});
  const Model& model = result.best.assessment.model;
  for (const char* name :
       {"dark_current", "shot_noise", "pixel_gain_spread", "pixel_offset_spread"})
    ASSERT_NE(model.find(name), nullptr) << name << " of " << steps_of(result);
  EXPECT_NEAR(model.find("shot_noise")->value("electrons_per_dn"), 4, 0.1);
  EXPECT_NEAR(model.find("dark_current")->value("electrons_per_s"), 4000, 150);
  EXPECT_NEAR(model.find("pixel_gain_spread")->value("sigma"), 0.08, 0.01);
  EXPECT_NEAR(model.find("pixel_offset_spread")->value("sigma_dn"), 1.5, 0.2);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.03);
}

// The first candidate or its declared ties hold both.
void expect_tie(const SearchResult& result, const std::string& a, const std::string& b) {
  ASSERT_FALSE(result.first.candidates.empty());
  const Candidate& first = result.first.candidates.front();
  EXPECT_TRUE(first.significant);
  std::vector<std::string> names = first.indistinguishable_from;
  names.push_back(first.effect->name);
  for (const std::string& name : {a, b})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1)
        << name << " in " << fmt::format("{}", first.effect->name);
  ASSERT_EQ(result.steps.size(), 1u) << steps_of(result);
  std::vector<std::string> step = result.steps[0].indistinguishable_from;
  step.push_back(result.steps[0].effect);
  for (const std::string& name : {a, b})
    EXPECT_EQ(std::count(step.begin(), step.end(), name), 1) << name;
}

// One level of light tells neither how a variance grows with the light nor how a pattern does.
TEST(PhotometryPairs, DeclaredTiedAtOneLevelOfLight) {
  expect_tie(found("shot-read", kSensor, "shot_noise: {electrons_per_dn: 25}", {0.5}, 12),
             "shot_noise", "read_noise");
  expect_tie(found("gain-offset", kNoise, "pixel_gain_spread: {sigma: 0.015}", {0.5}, 12),
             "pixel_gain_spread", "pixel_offset_spread");
}

// Of a search in fields of growing exposure by a camera with 0.28 DN an electron.
SearchResult found_with_pattern(double sigma) {
  const auto folder = std::filesystem::path(testing::TempDir()) / fmt::format("small-{}", sigma);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder / "protocol");
  std::string table = "frame,file,time_s,exposure_s,illumination\n";
  for (int frame = 0; frame < 40; ++frame) {
    table += fmt::format("{0},{0}.png,{1:.1f},{2:.4f},{3}\n", frame, 0.1 * frame,
                         0.001 * (1 + frame / 4), frame < 36 ? 1 : 0);
  }
  write_file_atomically(folder / "protocol" / "frames.csv", table);
  write_file_atomically(folder / "protocol" / "measurement.yaml",
                        "format: seam-measurement/1\nkind: photometry\ntitle: small pattern\n"
                        "camera: {width_px: 96, height_px: 72, bits: 12}\ngroup: frame\n"
                        "files: {frames: frames.csv}\n");
  measure_set(model_with(fmt::format(
                  "linear_response: {{gain_dn: 380, black_dn: 40}}, read_noise: {{sigma_dn: 3}}, "
                  "shot_noise: {{electrons_per_dn: 3.5714}}, pixel_gain_spread: {{sigma: {}}}",
                  sigma)),
              MeasurementSet::open(folder / "protocol"), {.seed = 3, .out = folder / "set"});
  const auto problem = open_problem(folder / "set");
  SearchResult result = search(*problem,
                               model_with("linear_response: {gain_dn: {value: 300, free: true}, "
                                          "black_dn: {value: 30, free: true}}, "
                                          "read_noise: {sigma_dn: {value: 4, free: true}}"),
                               {}, [](const std::string&) {});
  std::filesystem::remove_all(folder);
  return result;
}

// Photon noise takes over the variance of a pattern that is left out: it would be told 4 % wrong,
// twelve of its errors.
TEST(PhotometryPairs, ThePhotonNoiseIsRightBesideAPatternThatIsATrace) {
  const SearchResult result = found_with_pattern(0.0025);
  EXPECT_EQ(steps_of(result), "shot_noise ");
  ASSERT_EQ(result.kept.size(), 1u);
  EXPECT_EQ(result.kept[0].effect, "pixel_gain_spread");
  EXPECT_EQ(result.kept[0].value.effect, "shot_noise");
  const Assessment& best = result.best.assessment;
  const auto k = index_of(best.unknowns, {"shot_noise", 0});
  ASSERT_TRUE(k.has_value());
  EXPECT_NEAR(best.fit.value[*k], 3.5714, 3.5 * best.fit.sigma[*k]);
  EXPECT_LT(best.fit.sigma[*k], 0.005 * 3.5714);
  EXPECT_NEAR(best.model.find("pixel_gain_spread")->values()[0], 0.0025, 0.00025);
}

TEST(PhotometryPairs, ASmallerPatternIsLeftOut) {
  const SearchResult result = found_with_pattern(0.0006);
  EXPECT_EQ(steps_of(result), "shot_noise ");
  EXPECT_TRUE(result.kept.empty());
}

}  // namespace
}  // namespace seam::measurement
