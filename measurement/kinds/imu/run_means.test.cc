#include "measurement/kinds/imu/run_means.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/report/told.h"
#include "measurement/search/models/compare.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr size_t kSamples = 1024;
constexpr double kWhite = 2e-3;  // Of a sample, rad/s; of the accelerometer ten times that.

// Runs at rest with a bias of each, so many standard errors of a run's mean.
std::filesystem::path rests(const std::string& name, uint64_t runs, double standard_errors,
                            uint64_t seed, bool has_force = false) {
  const auto folder = std::filesystem::path(testing::TempDir()) / ("rests-" + name);
  std::filesystem::create_directories(folder);
  std::string rows = "run,time_s,wx_radps,wy_radps,wz_radps";
  rows += has_force ? ",ax_mps2,ay_mps2,az_mps2\n" : "\n";
  const double bias = standard_errors * kWhite / std::sqrt(double{kSamples});
  for (uint64_t run = 0; run < runs; ++run) {
    for (uint64_t i = 0; i < kSamples; ++i) {
      rows += fmt::format("{},{:.3f}", run,
                          100.0 * static_cast<double>(run) + 0.005 * static_cast<double>(i));
      for (uint64_t axis = 0; axis < (has_force ? 6U : 3U); ++axis) {
        const double size = axis < 3 ? 1 : 10;
        const double off = axis < 3 && has_force ? 0 : bias * normal({seed, 1 + axis}, run);
        rows += fmt::format(
            ",{:.7f}", (axis == 5 ? 9.8 : 0) +
                           size * (off + kWhite * normal({seed, 11 + axis}, run * kSamples + i)));
      }
      rows += '\n';
    }
  }
  write_file_atomically(folder / "imu.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: imu\nfiles: {imu: imu.csv}\n");
  return folder;
}

Model sensor(bool has_force = false) {
  const std::string white =
      "{x_U: {value: 1e-4, free: true}, y_U: {value: 1e-4, free: true}, z_U: {value: 1e-4, free: "
      "true}}";
  const auto of = [&](const std::string& unit) {
    std::string text = white;
    for (size_t at; (at = text.find('U')) != std::string::npos;) text.replace(at, 1, unit);
    return text;
  };
  std::string effects =
      "gyro_bias: {x_radps: {value: 0, free: true}, y_radps: {value: 0, free: true}, z_radps: "
      "{value: 0, free: true}}, gyro_white_noise: " +
      of("radps_rthz");
  if (has_force) effects += ", accel_white_noise: " + of("mps2_rthz");
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "test.yaml"));
}

std::vector<std::string> findings_of(const std::filesystem::path& folder, bool has_force = false) {
  const auto problem = open_problem(folder);
  std::vector<std::string> texts;
  for (const Structure& s : compare(*problem, sensor(has_force)).structure)
    texts.push_back(told_structure(problem->facts(), s));
  return texts;
}

TEST(RunMeans, ABiasOfEachRunIsNoticedInFewRunsAndInMany) {
  for (const uint64_t runs : {4, 20}) {
    const auto texts = findings_of(rests("apart", runs, 18, runs));
    ASSERT_FALSE(texts.empty()) << runs;
    EXPECT_THAT(texts, testing::Each(testing::HasSubstr("differs from run to run"))) << runs;
  }
}

TEST(RunMeans, TheSizeOfTheForceIsCompared) {
  EXPECT_THAT(findings_of(rests("force", 4, 18, 3, true), true),
              testing::ElementsAre("mean of gravity_mps2 differs from run to run"));
}

TEST(RunMeans, EqualMeansAreQuiet) {
  for (uint64_t seed = 1; seed <= 6; ++seed)
    EXPECT_TRUE(
        findings_of(rests("equal", seed % 2 == 0 ? 4 : 20, 0, seed, seed < 4), seed < 4).empty())
        << seed;
}

// Of normal means one set in twenty is below 0.05: between these in 99.9 %.
TEST(RunMeans, ChanceIsAsOftenAsItSays) {
  size_t below = 0;
  for (uint64_t set = 0; set < 1000; ++set) {
    std::vector<RunMean> means;
    for (uint64_t run = 0; run < 6; ++run)
      means.push_back({2 * normal({set, 1}, run), 4, 10.0 * static_cast<double>(run), 10});
    below += runs_apart(means, {}, 1e6).p_value < 0.05;
  }
  EXPECT_GT(below, 29U);
  EXPECT_LT(below, 75U);
}

// A bias that walks on between the runs is no other cause.
TEST(RunMeans, AWalkMovesThem) {
  std::vector<RunMean> means;
  for (int run = 0; run < 6; ++run) means.push_back({3.0 * run, 0.01, 100.0 * run, 10});
  EXPECT_LT(runs_apart(means, {}, 4).p_value, 1e-6);
  EXPECT_GT(runs_apart(means, {.walk = 0.5}, 4).p_value, 0.05);
}

}  // namespace
}  // namespace seam::measurement
