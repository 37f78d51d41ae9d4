// Formulas read further columns of their set wherever they act: a lens that is longer when it is
// warm, a body that slips under its load, a beacon whose ranges grow as its battery runs down.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/fitting/assess.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/views_testing.h"
#include "measurement/suggest/suggest.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;

Model model_with(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {" + effects + "}\n", "test.yaml"));
}

constexpr const char* kPinhole =
    "pinhole: {fx_px: {value: 500, free: true}, fy_px: {value: 500, free: true}, cx_px: {value: "
    "320, free: true}, cy_px: {value: 240, free: true}}";

Suggestion formula_of(const fs::path& folder, const std::string& effects) {
  const auto problem = open_problem(folder);
  const Model model = model_with(effects);
  problem->prepare(model);
  const auto found =
      suggest(*problem, {.assessment = assess(*problem, model, refitted_unknowns(model))});
  if (!found) return {};
  EXPECT_LT(found->error, 1.1);
  return *found;
}

// Twelve views of 9 x 7 corners, each 1.5 K warmer than the one before: focal length grows by 2 per
// mille a kelvin.
fs::path warm_views() {
  const RandomStream lot{.seed = 8};
  std::string rows;
  uint64_t draw = 0;
  const auto within = [&](double limit) { return limit * (2 * uniform(lot, draw++) - 1); };
  for (int frame = 0; frame < 12; ++frame) {
    const double yaw = within(0.6), pitch = within(0.6), cx = within(0.05), cy = within(0.05),
                 warm = frame * 7 % 12 * 1.5, f = 500 * (1 + 0.002 * warm);
    for (int point = 0; point < 63; ++point) {
      const double a = 0.04 * (point % 9 - 4), b = 0.04 * (point / 9 - 3);
      const double y = std::cos(pitch) * b, z = std::sin(pitch) * b;
      const double x3 = cx + std::cos(yaw) * a + std::sin(yaw) * z,
                   z3 = 0.5 - std::sin(yaw) * a + std::cos(yaw) * z;
      rows +=
          fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f},{:.2f}\n", frame, 0, point, a, b,
                      f * x3 / z3 + 319.5 + 0.1 * normal(lot.child("u"), draw),
                      f * (y + cy) / z3 + 239.5 + 0.1 * normal(lot.child("v"), draw), 20 + warm);
      ++draw;
    }
  }
  return write_views("columns-views", rows, "noise: {u_px: 0.1, v_px: 0.1}\n", ",temperature_c");
}

TEST(ColumnFormula, ALensIsLongerWhenItIsWarm) {
  const Suggestion found = formula_of(warm_views(), kPinhole);
  EXPECT_THAT(found.formula, ContainsRegex("^u: 0[.]00[0-9]+ [*] [(]u - cx[)] [*] temperature_c"));
  // At 0 degrees the focal length is 500 (1 - 20 * 0.002).
  ASSERT_EQ(found.numbers.size(), 1u);
  EXPECT_NEAR(found.numbers[0].value, 0.002 / 0.96, 4 * found.numbers[0].sigma);
  EXPECT_LT(found.numbers[0].sigma, 0.0005);
}

// Twelve runs of one second straight on, which lose 3 per cent of their way for each kilogramme.
TEST(ColumnFormula, ABodySlipsUnderItsLoad) {
  const fs::path folder = fs::path(testing::TempDir()) / "columns-walks";
  fs::create_directories(folder);
  std::string rows = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad,load_kg\n";
  for (uint64_t run = 0; run < 12; ++run) {
    const double load = static_cast<double>(run * 5 % 12),
                 v = 0.2 + 0.02 * static_cast<double>(run);
    for (uint64_t k = 0; k < 50; ++k) {
      const double t = 0.02 * static_cast<double>(k);
      const auto noise = [&](uint64_t channel) {
        return 0.0005 * normal({7, channel}, 50 * run + k);
      };
      rows += fmt::format("{},{:.2f},{:.3f},0,0,{:.6f},{:.6f},{:.6f},{}\n", run, t, v,
                          v * t * (1 - 0.03 * load) + noise(1), noise(2), noise(3), load);
    }
  }
  write_file_atomically(folder / "odometry.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: odometry\nnoise: {x_m: 0.0005, y_m: "
                        "0.0005, theta_rad: 0.0005}\nfiles: {odometry: odometry.csv}\n");
  EXPECT_THAT(formula_of(folder, "ideal_odometry: {}").formula, HasSubstr("* load_kg"));
}

// Ranges to four beacons, 5 cm longer for each volt that the battery lacks.
fs::path tired_beacons() {
  const fs::path folder = fs::path(testing::TempDir()) / "columns-beacons";
  fs::create_directories(folder);
  std::string map = "landmark,x_m,y_m\n", walk = "run,time_s,x_m,y_m,theta_rad\n",
              seen = "run,time_s,landmark,range_m,battery_v\n";
  const double places[4][2] = {{0, 0}, {6, 0}, {6, 5}, {0, 5}};
  for (int k = 0; k < 4; ++k) map += fmt::format("{},{},{}\n", k, places[k][0], places[k][1]);
  for (int run = 0; run < 8; ++run) {
    for (int i = 0; i < 100; ++i) {
      const double t = 0.1 * i, x = 3 + 2.5 * std::sin(0.33 * t + run),
                   y = 2.5 + 2 * std::cos(0.27 * t + 2 * run),
                   lacks = std::fmod(0.7 * run + t / 9, 2);
      walk += fmt::format("{},{:.2f},{:.6f},{:.6f},0\n", run, t, x, y);
      const double range = std::hypot(places[i % 4][0] - x, places[i % 4][1] - y) + 0.05 * lacks +
                           0.01 * normal({3, static_cast<uint64_t>(run)}, static_cast<uint64_t>(i));
      seen += fmt::format("{},{:.2f},{},{:.5f},{:.3f}\n", run, t, i % 4, range, 12 - lacks);
    }
  }
  write_file_atomically(folder / "map.csv", map);
  write_file_atomically(folder / "walk.csv", walk);
  write_file_atomically(folder / "seen.csv", seen);
  write_file_atomically(folder / "measurement.yaml",
                        "format: seam-measurement/1\nkind: landmarks\nnoise: {range_m: 0.01}\n"
                        "files: {observations: seen.csv, landmarks: map.csv, poses: walk.csv}\n");
  return folder;
}

TEST(ColumnFormula, RangesGrowAsABatteryRunsDown) {
  EXPECT_THAT(formula_of(tired_beacons(), "ideal_detector: {}").formula, HasSubstr("battery_v"));
}

// The simulator has no columns, but a set must have those that a formula names.
TEST(ColumnFormula, AColumnThatTheSetLacksIsTold) {
  const auto problem = open_problem(warm_views());
  const Model model = model_with(std::string(kPinhole) +
                                 ", warm: {stage: geometry, u: \"u + k * temperatur_c\", "
                                 "parameters: {k: {value: 0.1}}}");
  EXPECT_THAT([&] { problem->check_model(model); },
              testing::ThrowsMessage<InputError>(
                  ContainsRegex("points.csv: effect 'warm' reads column 'temperatur_c', which the "
                                "set lacks.*temperature_c")));
}

}  // namespace
}  // namespace seam::measurement
