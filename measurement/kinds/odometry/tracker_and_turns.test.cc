// A pose that is measured beside the axle, and turns to the left unlike those to the right: found
// by their names in sets that are made here by formulas of their own, and not where there are none.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/odometry/odometry.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;

constexpr double kNoise_m = 0.0005, kNoise_rad = 0.0008;

struct Drive {
  std::string name;
  double x_m = 0, y_m = 0;       // Of the tracker.
  double scale = 0, excess = 0;  // Of turns.
  double drift_rad_per_m = 0;
  double pile_rad_per_m = 0;  // A carpet's: turns by where the body heads.
  uint64_t seed = 1;
};

// Twelve runs of legs of 0.6 s with commands drawn at random, and poses each 20 ms, by small steps.
fs::path driven(const Drive& what) {
  const fs::path folder = fs::path(testing::TempDir()) / ("drive-" + what.name);
  fs::create_directories(folder);
  std::string rows = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad\n";
  for (uint64_t run = 0; run < 12; ++run) {
    const auto draw = [&](uint64_t stream, uint64_t k) {
      return normal({what.seed, 100 * run + stream}, k);
    };
    double x = 0.3 * draw(0, 0), y = 0.3 * draw(0, 1), theta = draw(0, 2), vx = 0, omega = 0;
    for (uint64_t k = 0; k < 120; ++k) {
      if (k % 30 == 0) vx = 0.2 + 0.1 * draw(1, k), omega = 0.9 * draw(2, k);
      const double px = x + what.x_m * std::cos(theta) - what.y_m * std::sin(theta),
                   py = y + what.x_m * std::sin(theta) + what.y_m * std::cos(theta);
      rows += fmt::format("{},{:.3f},{:.6f},0,{:.6f},{:.7f},{:.7f},{:.7f}\n", run,
                          0.02 * static_cast<double>(k), vx, omega, px + kNoise_m * draw(3, 3 * k),
                          py + kNoise_m * draw(3, 3 * k + 1),
                          std::remainder(theta + kNoise_rad * draw(3, 3 * k + 2), 2 * M_PI));
      const double turned = omega * (1 + what.scale) + what.excess * std::max(omega, 0.0) +
                            what.drift_rad_per_m * std::abs(vx) +
                            what.pile_rad_per_m * vx * std::sin(2 * theta);
      for (int step = 0; step < 20; ++step) {
        x += 0.001 * vx * std::cos(theta + 0.0005 * turned);
        y += 0.001 * vx * std::sin(theta + 0.0005 * turned);
        theta += 0.001 * turned;
      }
    }
  }
  write_file_atomically(folder / "odometry.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: odometry\nfiles: {odometry: "
                        "odometry.csv}\n");
  return folder;
}

SearchResult searched(const fs::path& folder) {
  const Model nominal = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {ideal_odometry: {}}\n", "model"));
  const auto problem = open_problem(folder);
  return search(*problem, nominal, {}, [](const std::string&) {});
}

void expect_value(const Model& model, const std::string& effect, size_t parameter, double truth) {
  constexpr double kWithin = 0.003;  // Metres or shares: a tenth of the truth, and far above noise.
  const effects::ModelEffect* found = model.find(effect);
  ASSERT_NE(found, nullptr) << effect;
  EXPECT_NEAR(found->values()[parameter], truth, kWithin) << effect << " " << parameter;
}

TEST(TrackerBesideTheAxle, IsFoundWhereItIs) {
  for (const uint64_t seed : {1, 2}) {
    const SearchResult result = searched(
        driven({.name = fmt::format("beside-{}", seed), .x_m = 0.08, .y_m = -0.03, .seed = seed}));
    const Model& model = result.best.assessment.model;
    ASSERT_EQ(result.steps.size(), 1u) << model.to_yaml();
    expect_value(model, "tracker_offset", 0, 0.08);
    expect_value(model, "tracker_offset", 1, -0.03);
    EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
  }
}

TEST(UnlikeTurns, AreFoundAndAreNoDrift) {
  // Left turns alone have one name; right turns alone are both turns, and left ones less.
  const SearchResult left = searched(driven({.name = "left", .excess = 0.05, .seed = 3}));
  expect_value(left.best.assessment.model, "turn_asymmetry", 0, 0.05);
  EXPECT_EQ(left.steps.size(), 1u) << left.best.assessment.model.to_yaml();
  const SearchResult right =
      searched(driven({.name = "right", .scale = 0.05, .excess = -0.05, .seed = 3}));
  expect_value(right.best.assessment.model, "turn_asymmetry", 0, -0.05);
  expect_value(right.best.assessment.model, "odometry_scale", 2, 0.05);
  EXPECT_EQ(right.steps.size(), 2u) << right.best.assessment.model.to_yaml();
  const SearchResult drift =
      searched(driven({.name = "drift", .drift_rad_per_m = 0.06, .seed = 4}));
  expect_value(drift.best.assessment.model, "heading_drift", 0, 0.06);
  EXPECT_EQ(drift.steps.size(), 1u) << drift.best.assessment.model.to_yaml();
}

TEST(UnlikeTurns, AreNotFoundWhereThereAreNone) {
  for (const uint64_t seed : {5, 6, 7}) {
    const SearchResult result =
        searched(driven({.name = fmt::format("plain-{}", seed), .seed = seed}));
    const Model& model = result.best.assessment.model;
    for (const char* effect : {"turn_asymmetry", "tracker_offset", "heading_drift"})
      EXPECT_FALSE(model.has(effect)) << model.to_yaml();
  }
}

// `measure` draws what the sets above are made by.
TEST(TrackerBesideTheAxle, IsMeasuredAsTheFormulaSays) {
  const fs::path protocol = driven({.name = "protocol"}), out = protocol / "made";
  fs::remove_all(out);
  const Model truth = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {tracker_offset: {x_m: 0.08, y_m: "
                            "-0.03}, turn_asymmetry: {left_excess: 0.04}}\n",
                            "truth"));
  measure_set(truth, MeasurementSet::open(protocol), {.seed = 1, .noise = false, .out = out});
  const CsvTable here = CsvTable::read(
                     driven({.name = "same", .x_m = 0.08, .y_m = -0.03, .excess = 0.04}) /
                     "odometry.csv"),
                 made = CsvTable::read(out / "odometry.csv");
  ASSERT_EQ(here.rows(), made.rows());
  const auto x = made.numbers("x_m"), y = made.numbers("y_m"), theta = made.numbers("theta_rad");
  const auto x0 = here.numbers("x_m"), y0 = here.numbers("y_m"), theta0 = here.numbers("theta_rad");
  // A made run starts at the origin, facing +x.
  for (size_t k = 0; k < 120; ++k) {
    const double c = std::cos(theta0[0]), s = std::sin(theta0[0]);
    EXPECT_NEAR(c * (x0[k] - x0[0]) + s * (y0[k] - y0[0]), x[k], 8 * kNoise_m) << k;
    EXPECT_NEAR(-s * (x0[k] - x0[0]) + c * (y0[k] - y0[0]), y[k], 8 * kNoise_m) << k;
    EXPECT_NEAR(std::remainder(theta0[k] - theta0[0] - theta[k], 2 * M_PI), 0, 8 * kNoise_rad) << k;
  }
}

// No effect has it, and noise of the way would take it: what it depends on is told, not that noise.
TEST(Floor, ThatTurnsABodyByItsHeadingIsACauseWithoutAName) {
  const SearchResult result = searched(driven({.name = "pile", .pile_rad_per_m = 0.1}));
  ASSERT_TRUE(result.unnamed);
  ASSERT_FALSE(result.unnamed->depends_on.empty());
  EXPECT_EQ(result.unnamed->depends_on[0], std::vector<std::string>{"heading"});
  EXPECT_TRUE(result.steps.empty());
  EXPECT_LT(result.unnamed->error_after, 1.1);
}

}  // namespace
}  // namespace seam::measurement
