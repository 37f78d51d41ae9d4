// Beacons whose ranges are too long by a constant of each, and beacons that lie off their places:
// each is found for what it is, in sets that are made here by a formula of their own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

constexpr double kNoise_m = 0.03;
using FourValues = std::array<double, 4>;
constexpr FourValues kNone = {0, 0, 0, 0};
constexpr double kPlaces[4][2] = {{0, 0}, {6, 0}, {6, 5}, {0, 5}};

struct Room {
  std::string name;
  FourValues delay_m = kNone, east_m = kNone;  // Of the beacons.
  int runs = 2;
  uint64_t seed = 1;
};

// A walk through a room with a beacon in each corner, which hears one of them every 0.2 s.
fs::path made(const Room& room) {
  const fs::path folder = fs::path(testing::TempDir()) / ("beacons-" + room.name);
  fs::create_directories(folder);
  std::string map = "landmark,x_m,y_m\n", walk = "run,time_s,x_m,y_m,theta_rad\n",
              seen = "run,time_s,block,landmark,range_m\n";
  for (int k = 0; k < 4; ++k) map += fmt::format("{},{},{}\n", k + 1, kPlaces[k][0], kPlaces[k][1]);
  for (int run = 0; run < room.runs; ++run) {
    for (int i = 0; i < 1200; ++i) {
      const double t = 0.1 * i, x = 3 + 2.5 * std::sin(0.33 * t + run),
                   y = 2.5 + 2 * std::cos(0.27 * t + 2 * run);
      walk += fmt::format("{},{:.2f},{:.6f},{:.6f},{:.6f}\n", run, t, x, y, 0.2 * std::sin(t));
      if (i % 2 != 0) continue;
      const int k = i / 2 % 4;
      const double range =
          std::hypot(kPlaces[k][0] + room.east_m[k] - x, kPlaces[k][1] - y) + room.delay_m[k] +
          kNoise_m * normal({room.seed, static_cast<uint64_t>(run)}, static_cast<uint64_t>(i));
      seen += fmt::format("{},{:.2f},{}-{},{},{:.5f}\n", run, t, run, i / 120, k + 1, range);
    }
  }
  write_file_atomically(folder / "map.csv", map);
  write_file_atomically(folder / "walk.csv", walk);
  write_file_atomically(folder / "seen.csv", seen);
  write_file_atomically(
      folder / "measurement.yaml",
      fmt::format("format: seam-measurement/1\nkind: landmarks\ngroup: {}\n"
                  "files: {{observations: seen.csv, landmarks: map.csv, poses: walk.csv}}\n",
                  room.runs > 1 ? "run" : "block"));
  return folder;
}

struct Found {
  SearchResult result;
  std::vector<Finding> findings;
};

Found searched(const Room& room) {
  const Model nominal = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {ideal_detector: {}}\n", "model"));
  const auto problem = open_problem(made(room));
  Found found{.result = search(*problem, nominal, {}, [](const std::string&) {})};
  found.findings = problem->findings(found.result.best.assessment.model);
  return found;
}

TEST(BeaconDelays, AreFoundWithTheirSizes) {
  for (const int runs : {1, 2}) {
    const Room room{
        .name = fmt::format("delayed-{}", runs), .delay_m = {0.15, -0.05, 0.3, 0.02}, .runs = runs};
    const Found found = searched(room);
    const Model& model = found.result.best.assessment.model;
    EXPECT_TRUE(model.has("landmark_delay")) << model.to_yaml();
    EXPECT_FALSE(model.has("landmark_scatter")) << model.to_yaml();
    std::map<std::string, double> delays;
    for (const Finding& one : found.findings) {
      ASSERT_EQ(one.values[0].first, "delay_m") << one.text;
      EXPECT_NEAR(one.values[0].second, room.delay_m[std::stoul(one.name) - 1],
                  4 * one.values[1].second)
          << one.text;
      delays[one.name] = one.values[0].second;
    }
    EXPECT_TRUE(delays.contains("1") && delays.contains("2") && delays.contains("3"));
  }
}

TEST(BeaconDelays, AreNotThoseOfBeaconsThatLieElsewhere) {
  const Found found = searched({.name = "elsewhere", .east_m = {0.12, -0.1, 0.15, 0}, .seed = 2});
  const Model& model = found.result.best.assessment.model;
  EXPECT_TRUE(model.has("landmark_scatter")) << model.to_yaml();
  EXPECT_FALSE(model.has("landmark_delay")) << model.to_yaml();
  for (const uint64_t seed : {3, 4}) {
    const Found plain = searched({.name = fmt::format("plain-{}", seed), .seed = seed});
    EXPECT_TRUE(plain.result.steps.empty()) << plain.result.best.assessment.model.to_yaml();
  }
}

}  // namespace
}  // namespace seam::measurement
