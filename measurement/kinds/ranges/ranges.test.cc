// Sets of ranges with a camera of one grey and a detector that reads the distance from one pixel,
// so that everything can be calculated by hand. The real ones: tests/ranges_test.py.
#include "measurement/kinds/ranges/ranges.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

constexpr double kDnPerMetre = 100;
constexpr int kTrials = 24;  // As predictions take.

// All light is the ball's distance.
class GreyCamera final : public FramePredictor {
 public:
  GreyCamera(int width_px, int height_px)
      : samples_(static_cast<size_t>(width_px) * height_px * 3) {}
  std::vector<float> light(const FrameJob& job) const override {
    const Vec3 ball = job.instants.front().primitives.front().X_WO.p;
    return std::vector<float>(samples_,
                              static_cast<float>(std::hypot(ball.x, ball.y) * kDnPerMetre / 255));
  }

 private:
  size_t samples_;
};

class FirstPixel final : public RangeDetector {
 public:
  explicit FirstPixel(const RangeDetectorSpec& spec)
      : width_px_(spec.width_px), height_px_(spec.height_px) {}
  Gaze gaze(const Model&, double) const override { return {}; }
  std::vector<uint8_t> colours(std::span<const uint8_t> rgb) const override {
    return {rgb.begin(), rgb.end()};
  }
  PixelWindow whole(const PixelWindow&) const override { return {0, 0, width_px_, height_px_}; }
  void recolour(const PixelWindow&, std::span<const uint8_t> rgb,
                std::vector<uint8_t>& colours) const override {
    colours.assign(rgb.begin(), rgb.end());
  }
  std::optional<RangeSighting> measure(std::span<const uint8_t> colours,
                                       const Gaze&) const override {
    if (colours[0] > 250) return std::nullopt;
    return RangeSighting{colours[0] / kDnPerMetre, 0};
  }

 private:
  int width_px_, height_px_;
};

class Ranges : public testing::Test {
 protected:
  void SetUp() override {
    instruments_.render = [](const SceneFiles&) {
      return [](const Model&, int width_px, int height_px, SimTime, Detail) {
        return std::make_unique<GreyCamera>(width_px, height_px);
      };
    };
    instruments_.detect = [](const RangeDetectorSpec& spec) -> std::unique_ptr<RangeDetector> {
      if (spec.name != "first_pixel") return nullptr;
      return std::make_unique<FirstPixel>(spec);
    };
    instruments_.detectors = {"first_pixel"};
    folder_ = testing::TempDir() + "/ranges_" +
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    write("scene.yaml",
          "format: seam-scene/1\nbackground_rgb: [0, 0, 0]\n"
          "objects: [{shape: sphere, centre_m: [1, 0, 0.04], radius_m: 0.04, rgb: [1, 1, 1]}]\n");
    write("measurement.yaml",
          "format: seam-measurement/1\nkind: ranges\ncamera: {width_px: 16, height_px: 8}\nscene: "
          "scene.yaml\n"
          "detector: first_pixel\nfiles: {ranges: ranges.csv}\n");
  }
  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
  }
  std::unique_ptr<Problem> open() const { return open_problem(folder_, instruments_); }
  static Model model(const std::string& effects = "") {
    return Model::from_config(
        ConfigNode::from_text("format: seam-model/1\neffects:\n  pinhole: {fx_px: 16, fy_px: 16, "
                              "cx_px: 7.5, cy_px: 3.5}\n" +
                                  effects,
                              "model"));
  }
  std::filesystem::path folder_;
  Instruments instruments_;
};

TEST(VarianceOfSpread, IsThatOfSamples) {
  // Normal values, and values that jump rarely: sample deviations of 30 of them, many times.
  const RandomStream stream{.seed = 3};
  for (const bool jumps : {false, true}) {
    constexpr int kN = 30, kTimes = 4000;
    double sum = 0, sum2 = 0;
    for (int t = 0; t < kTimes; ++t) {
      double mean = 0, square = 0;
      for (int i = 0; i < kN; ++i) {
        const uint64_t at = static_cast<uint64_t>(t) * kN + i;
        const double x = jumps ? (uniform(stream, at) < 0.3 ? 1.0 : 0.0) : normal(stream, at);
        mean += x / kN, square += x * x;
      }
      const double s = std::sqrt((square - kN * mean * mean) / (kN - 1));
      sum += s, sum2 += s * s;
    }
    const double sampled = sum2 / kTimes - sum / kTimes * (sum / kTimes);
    const double variance = jumps ? 0.21 : 1,
                 fourth = jumps ? 0.3 * 0.7 * (0.3 * 0.3 * 0.3 + 0.7 * 0.7 * 0.7) : 3;
    // Never less than what normal values have.
    const double expected = std::max(sampled, variance / (2 * (kN - 1)));
    EXPECT_NEAR(variance_of_spread(variance, fourth, kN), expected, 0.1 * expected) << jumps;
  }
  EXPECT_EQ(variance_of_spread(0, 0, 10), 0);
}

TEST_F(Ranges, ResidualsAreThoseOfMeanAndSpreadOverTheirErrors) {
  write("ranges.csv",
        "trial,true_m,measured_m\n1,0.5,0.50\n2,0.5,0.53\n3,0.5,0.56\n1,0.8,0.81\n2,0.8,0.79\n3,0."
        "8,0.80\n");
  const auto problem = open();
  const Facts& facts = problem->facts();
  // Three trials: each is a side of its own, with one measurement a place and so without a spread.
  EXPECT_EQ(facts.rows(), 6u);
  EXPECT_EQ(facts.scalars(), 6u);
  EXPECT_EQ(problem->folds().size(), 3u);

  const Model noisy = model("  read_noise: {sigma_dn: 3}\n");
  problem->prepare(noisy);
  const Evaluation here = problem->evaluate(noisy, problem->all_groups());
  const double single = std::sqrt(9 + 1.0 / 12) / kDnPerMetre;
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(here.residual[i], 0.03 * static_cast<double>(i), 3.5 * single / std::sqrt(kTrials))
        << i;
    // Its own noise, and the simulation's, which the three sides share.
    EXPECT_NEAR(here.sigma[i], single * std::sqrt(1 + 3.0 / kTrials), 0.4 * single) << i;
    EXPECT_DOUBLE_EQ(here.whitened[i], here.residual[i] / here.sigma[i]);
  }
  // A model whose ball is nearer by 10 %.
  const Model nearer = model("  read_noise: {sigma_dn: 3}\n  range_scale: {scale: -0.1}\n");
  const Evaluation there = problem->evaluate(nearer, problem->all_groups());
  EXPECT_NEAR(there.residual[0] - here.residual[0], 0.05, 0.004);
  EXPECT_NEAR(there.residual[3] - here.residual[3], 0.08, 0.004);
}

TEST_F(Ranges, SpreadsAreObservationsToo) {
  std::string table = "trial,true_m,measured_m\n";
  for (int k = 0; k < 40; ++k) {
    for (const double d : {0.5, 0.8})
      table += fmt::format("{},{},{}\n", k, d, d + 0.04 * (k % 2 == 0 ? 1 : -1));
  }
  write("ranges.csv", table);
  const auto problem = open();
  // Trials are held out whole: 12 of 40, at both places.
  ASSERT_EQ(problem->facts().rows(), 4u);
  ASSERT_EQ(problem->facts().scalars(), 8u);
  ASSERT_EQ(problem->folds().size(), 1u);
  const Model quiet = model("  read_noise: {sigma_dn: 1}\n"),
              noisy = model("  read_noise: {sigma_dn: 4}\n");
  problem->prepare(quiet);
  const auto spread_z = [&](const Model& m) {
    const Evaluation e = problem->evaluate(m, problem->all_groups());
    EXPECT_EQ(problem->facts().channels[problem->facts().channel_of[1]].name, "spread_m");
    return e.whitened[1];
  };
  EXPECT_GT(spread_z(quiet), 10);
  EXPECT_LT(std::abs(spread_z(noisy)), 4);
  // A fit of the noise finds the deviation of two values 4 cm to either side.
  const Fit fit = problem->fit(quiet, {{"read_noise", 0}}, problem->all_groups());
  EXPECT_NEAR(fit.value[0], 4, 0.8);
}

TEST_F(Ranges, OneGrossValueIsAnOutlierOfItsOwn) {
  std::string table = "trial,true_m,measured_m\n";
  for (int k = 0; k < 10; ++k)
    table += fmt::format("{},0.5,{}\n", k, k == 4 ? 1.9 : 0.5 + 0.001 * (k % 3));
  for (int k = 0; k < 10; ++k) table += fmt::format("{},0.8,0.8\n", k);
  write("ranges.csv", table);
  const auto problem = open();
  const auto outliers = problem->find_outliers(model());
  ASSERT_EQ(std::count(outliers.begin(), outliers.end(), 1), 1);
  const size_t scalar =
      static_cast<size_t>(std::find(outliers.begin(), outliers.end(), 1) - outliers.begin());
  EXPECT_EQ(problem->facts().line_of_row[problem->facts().row_of[scalar]], 6);
}

// Four places with offsets in no order: too few for any curve over the range, which is not tested.
TEST_F(Ranges, OffsetsWithoutOrderAreAStructureOfPlaces) {
  std::string table = "trial,true_m,measured_m\n";
  for (int k = 0; k < 10; ++k) {
    for (const auto& [d, off] : {std::pair(0.5, 0.1), {0.6, -0.1}, {0.7, 0.1}, {0.8, -0.1}})
      table += fmt::format("{},{},{}\n", k, d, d + off + 0.001 * (k % 3));
  }
  write("ranges.csv", table);
  const auto problem = open();
  problem->prepare(model());
  std::vector<std::string> covariates;
  for (const Structure& s : problem->structure(model(), problem->all_groups(), 0)) {
    if (s.residual == "mean_m") covariates.push_back(s.covariate);
  }
  EXPECT_EQ(covariates, std::vector<std::string>{"place"});
}

TEST_F(Ranges, SaysWhichPlaceShowsNoBall) {
  write("ranges.csv", "trial,true_m,measured_m\n1,0.5,0.5\n2,2.53,2.5\n");
  const auto problem = open();
  EXPECT_THAT([&] { problem->prepare(model()); },
              testing::ThrowsMessage<InputError>(
                  testing::AllOf(testing::HasSubstr("ranges.csv:3"), testing::HasSubstr("2.53"))));
}

}  // namespace
}  // namespace seam::measurement
