// Ranges that are too long near a line on the floor, or more and more with time, in sets that are
// made here by a formula of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

constexpr double kPosts[4][2] = {{0, 0}, {6, 0}, {6, 5}, {0, 5}};
constexpr double kTagAhead_m = 0.3;  // Of the robot's middle.

// Of a shelf along 0.6 x + 0.8 y = 4, which reaches 0.5 m; sizes and noise in metres.
struct Yard {
  std::string name;
  double excess_m = 0, noise_m = 0;
  double drift_mps = 0;  // Of the clocks of the posts, of unlike sign and size.
  int runs = 4;
};

double at_shelf(const Yard& yard, double x, double y) {
  const double reaches = (0.6 * x + 0.8 * y - 4) / 0.5;
  return yard.excess_m / std::sqrt(std::exp(reaches * reaches));
}

fs::path made_yard(const Yard& yard) {
  const fs::path folder = fs::path(testing::TempDir()) / ("yard-" + yard.name);
  std::string map = "landmark,x_m,y_m\n", walk = "run,time_s,x_m,y_m,theta_rad\n",
              seen = "run,time_s,landmark,range_m\n";
  for (int k = 0; k < 4; ++k) map += fmt::format("{},{},{}\n", k, kPosts[k][0], kPosts[k][1]);
  for (int run = 0; run < yard.runs; ++run) {
    for (int i = 0; i < 600; ++i) {
      const double t = 0.1 * i, x = 3 + 2.5 * std::sin(0.33 * t + run),
                   y = 2.5 + 2 * std::cos(0.27 * t + 2 * run), turn = 0.4 * t;
      walk += fmt::format("{},{:.1f},{:.9f},{:.9f},{:.9f}\n", run, t, x, y, turn);
      if (i % 2 != 0) continue;
      const double tag_x = x + kTagAhead_m * std::cos(turn),
                   tag_y = y + kTagAhead_m * std::sin(turn);
      const double* beacon = kPosts[i / 2 % 4];
      const double range =
          std::sqrt(std::pow(beacon[0] - tag_x, 2) + std::pow(beacon[1] - tag_y, 2)) +
          at_shelf(yard, tag_x, tag_y) + yard.drift_mps * t * std::cos(2.0 * (i / 2 % 4)) +
          yard.noise_m * normal({9, static_cast<uint64_t>(run)}, static_cast<uint64_t>(i));
      seen += fmt::format("{},{:.1f},{},{:.9f}\n", run, t, i / 2 % 4, range);
    }
  }
  fs::create_directories(folder);
  write_file_atomically(folder / "map.csv", map);
  write_file_atomically(folder / "walk.csv", walk);
  write_file_atomically(folder / "seen.csv", seen);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format(
          "format: seam-measurement/1\nkind: landmarks\ngroup: run\nnoise: {{range_m: {}}}\n"
          "files: {{observations: seen.csv, landmarks: map.csv, poses: walk.csv}}\n",
          std::max(yard.noise_m, 1e-3)));
  return folder;
}

Model tag_with(const std::string& effects) {
  return Model::from_config(ConfigNode::from_text(
      fmt::format("format: seam-model/1\neffects: {{mount_offset: {{x_m: {}}}{}}}\n", kTagAhead_m,
                  effects),
      "model"));
}

// The place that counts is the tag's, not the robot's.
TEST(Walls, LengthenRangesByTheTagsPlace) {
  const auto problem = open_problem(made_yard({.name = "exact", .excess_m = 0.2}));
  const auto worst = [&](const std::string& effects) {
    double most = 0;
    for (const double left :
         problem->evaluate(tag_with(effects), problem->all_groups(), nullptr).residual)
      most = std::max(most, std::abs(left));
    return most;
  };
  const std::string shelf = ", wall_excess: {size_m: 0.2, at_m: 4, reach_m: 0.5, direction_rad: ";
  EXPECT_LT(worst(fmt::format("{}{:.15g}}}", shelf, std::atan2(0.8, 0.6))), 1e-6);
  // The same line from its other side is another one.
  EXPECT_GT(worst(fmt::format("{}{:.15g}}}", shelf, std::atan2(-0.8, -0.6))), 0.19);
  EXPECT_GT(worst(""), 0.19);
}

TEST(Walls, AreFoundWhereTheyStand) {
  const auto problem = open_problem(made_yard({.name = "noisy", .excess_m = 0.2, .noise_m = 0.04}));
  const SearchResult found = search(*problem, tag_with(""), {}, [](const std::string&) {});
  ASSERT_EQ(found.steps.size(), 1);
  ASSERT_EQ(found.steps[0].effect, "wall_excess");
  const Assessment& best = found.best.assessment;
  const std::vector<double> truth = {0.2, std::atan2(0.8, 0.6), 4, 0.5};
  for (size_t i = 0; i < truth.size(); ++i) {
    const auto* wall = best.model.find("wall_excess");
    EXPECT_NEAR(wall->parameters[i].value, truth[i], 0.06) << i;
  }
  const auto none = open_problem(made_yard({.name = "plain", .noise_m = 0.04}));
  EXPECT_TRUE(search(*none, tag_with(""), {}, [](const std::string&) {}).steps.empty());
}

// What each post does on its own, over time, has no name, and is neither a wall nor a height.
TEST(Posts, WhoseClocksRunUnlikeAreFunctionsOfTimeForEach) {
  const auto problem =
      open_problem(made_yard({.name = "clocks", .noise_m = 0.04, .drift_mps = 0.003}));
  const SearchResult found = search(*problem, tag_with(""), {}, [](const std::string&) {});
  ASSERT_TRUE(found.unnamed);
  EXPECT_EQ(found.unnamed->depends_on[0], (std::vector<std::string>{"time", "landmark"}));
  EXPECT_NEAR(found.unnamed->error_after, 1, 0.05);
  EXPECT_TRUE(found.steps.empty());
}

// A robot that stands has no places to compare.
TEST(Walls, NeedARobotThatMoves) {
  const fs::path folder = made_yard({.name = "still", .runs = 1});
  write_file_atomically(folder / "walk.csv",
                        "run,time_s,x_m,y_m,theta_rad\n0,0,1,2,0\n0,30,1,2,0\n0,70,1,2,0\n");
  const auto problem = open_problem(folder);
  EXPECT_NE(problem->not_testable(tag_with(""), *effects::find_effect("wall_excess"), 0), "");
}

}  // namespace
}  // namespace seam::measurement
