// A noise of unknown size is no effect, whatever it was estimated at; gross errors hide no mean.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "measurement/study/study.h"
#include "sim_core/base/files.h"
#include "sim_core/base/output.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

Model described(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: " + effects + "\n", "test.yaml"));
}

// A study's set of a kind as this model has it.
fs::path made_of(const std::string& kind, const std::string& truth, const std::string& name,
                 uint64_t seed = 5) {
  const fs::path protocol = fs::path(testing::TempDir()) / (name + "-protocol"),
                 out = fs::path(testing::TempDir()) / name;
  fs::create_directories(protocol);
  fs::remove_all(out);
  write_study_protocol(kind, protocol);
  measure_set(described(truth), MeasurementSet::open(protocol), {.seed = seed, .out = out});
  return out;
}

void forget_noise(const fs::path& set) {
  std::istringstream lines(read_file(set / "measurement.yaml"));
  std::string kept, line;
  while (std::getline(lines, line)) {
    if (line.rfind("noise:", 0) != 0) kept += line + "\n";
  }
  write_file_atomically(set / "measurement.yaml", kept);
}

SearchResult searched(Problem& problem, const std::string& given) {
  return search(problem, described(given), {}, [](const std::string&) {});
}

TEST(NoiseSize, AWrongEstimateIsToldAgainAndNoNoiseIsNamed) {
  const fs::path set =
      made_of("landmarks", "{ideal_detector: {}, range_scale: {scale: 0.05}}", "noise-size");
  forget_noise(set);
  const auto problem = open_problem(set);
  const std::vector<Channel> before = problem->facts().channels;
  problem->resize_noise({0.7, 1});
  const SearchResult result = searched(*problem, "{ideal_detector: {}}");
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.best.added.front(), "range_scale");
  EXPECT_EQ(result.verdict, "missing_effect");
  EXPECT_NEAR(result.best.assessment.error, 1, 0.1);
  EXPECT_NEAR(problem->facts().channels[0].noise / before[0].noise, 1, 0.1);
}

// The noise that was found before goes again: the model with it is less likely than the one given.
TEST(NoiseSize, AWrongEstimateAloneNamesNothing) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    const fs::path set = made_of("odometry", "{ideal_odometry: {}}", "noise-alone", seed);
    forget_noise(set);
    const auto problem = open_problem(set);
    problem->resize_noise(std::vector<double>(problem->facts().channels.size(), 0.4));
    const SearchResult result = searched(*problem, "{ideal_odometry: {}}");
    EXPECT_TRUE(result.best.added.empty()) << seed << " " << result.best.added.front();
    EXPECT_EQ(result.verdict, "adequate") << seed;
  }
}

TEST(NoiseSize, AStatedNoiseStaysAndWhatIsBeyondItIsNamed) {
  const auto problem = open_problem(made_of(
      "landmarks", "{ideal_detector: {}, range_wander: {sigma_m: 0.05, tau_s: 0}}", "stated"));
  const double before = problem->facts().channels[0].noise;
  const SearchResult result = searched(*problem, "{ideal_detector: {}}");
  EXPECT_FALSE(result.steps.empty());
  EXPECT_EQ(problem->facts().channels[0].noise, before);
}

TEST(NoiseSize, ANoiseThatHangsTogetherIsMoreThanAnotherSize) {
  const fs::path set = made_of(
      "landmarks", "{ideal_detector: {}, range_wander: {sigma_m: 0.08, tau_s: 1.5}}", "wanders");
  forget_noise(set);
  const auto problem = open_problem(set);
  const SearchResult result = searched(*problem, "{ideal_detector: {}}");
  ASSERT_FALSE(result.best.added.empty());
  EXPECT_EQ(result.best.added.front(), "range_wander");
}

// One row in eighty is a radian off: with the right limit the error is still a hundred times the
// noise, and a wander that covers these rows would leave less.
TEST(GrossErrors, FarFromTheNoiseTheyHideNoMean) {
  const fs::path set =
      made_of("joints", "{ideal_servo: {}, speed_limit: {rad_per_s: 1.5}}", "gross-errors");
  std::istringstream lines(read_file(set / "joints.csv"));
  std::string line, changed;
  std::getline(lines, line);
  changed = line + "\n";
  const auto column = [&](const std::string& name) {
    std::istringstream names(line);
    std::string cell;
    for (int i = 0; std::getline(names, cell, ','); ++i) {
      if (cell == name) return i;
    }
    return -1;
  };
  const int measured = column("measured_rad");
  ASSERT_GE(measured, 0);
  for (int row = 0; std::getline(lines, line); ++row) {
    std::istringstream cells(line);
    std::string cell, sum;
    for (int i = 0; std::getline(cells, cell, ','); ++i) {
      const bool gross = i == measured && row % 80 == 41;
      sum += (i > 0 ? "," : "") + (gross ? std::to_string(std::stod(cell) + 1) : cell);
    }
    changed += sum + "\n";
  }
  write_file_atomically(set / "joints.csv", changed);
  const auto problem = open_problem(set);
  const SearchResult result = searched(*problem, "{ideal_servo: {}}");
  ASSERT_EQ(result.best.added, std::vector<std::string>{"speed_limit"});
  EXPECT_NEAR(result.best.assessment.error, 1, 0.15);
  EXPECT_NEAR(result.best.assessment.model.find("speed_limit")->value("rad_per_s"), 1.5, 0.01);
  EXPECT_FALSE(result.outliers.empty());
}

}  // namespace
}  // namespace seam::measurement
