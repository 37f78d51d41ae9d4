// A floor that slopes takes a walking body aside, by its speed and whichever way it faces: a
// formula says so on the floor's own axes, in sets that are made here by small steps.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using testing::ContainsRegex;

constexpr double kNoise_m = 0.001, kNoise_rad = 0.002;

// Eight walks, each from a heading of its own, with a command that holds for a second or so.
std::filesystem::path walked(double down_x, double down_y) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "walks-on-a-slope";
  std::filesystem::create_directories(folder);
  std::string rows = "run,time_s,vx_cmd_mps,vy_cmd_mps,omega_cmd_radps,x_m,y_m,theta_rad\n";
  for (uint64_t run = 0; run < 8; ++run) {
    const auto draw = [&](uint64_t stream, uint64_t k) {
      return normal({7, 100 * run + stream}, k);
    };
    double x = 0, y = 0, theta = 2 * draw(0, 0), vx = 0, omega = 0;
    for (uint64_t k = 0; k < 100; ++k) {
      if (k % 12 == 0) vx = 0.2 + 0.1 * draw(1, k), omega = 0.5 * draw(2, k);
      rows +=
          fmt::format("{},{:.1f},{:.6f},0,{:.6f},{:.7f},{:.7f},{:.7f}\n", run,
                      0.1 * static_cast<double>(k), vx, omega, x + kNoise_m * draw(3, 3 * k),
                      y + kNoise_m * draw(3, 3 * k + 1), theta + kNoise_rad * draw(3, 3 * k + 2));
      for (int step = 0; step < 100; ++step) {
        const double middle = theta + 0.0005 * omega, aside = 0.001 * std::abs(vx);
        x += 0.001 * vx * std::cos(middle) + down_x * aside;
        y += 0.001 * vx * std::sin(middle) + down_y * aside;
        theta += 0.001 * omega;
      }
    }
  }
  write_file_atomically(folder / "odometry.csv", rows);
  write_file_atomically(folder / "measurement.yaml",
                        fmt::format("format: seam-measurement/1\nkind: odometry\ngroup: run\n"
                                    "noise: {{x_m: {0}, y_m: {0}, theta_rad: {1}}}\n"
                                    "files: {{odometry: odometry.csv}}\n",
                                    kNoise_m, kNoise_rad));
  return folder;
}

TEST(FloorFormula, ASlopeIsAWayAcrossTheFloor) {
  const Model nominal = Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects: {ideal_odometry: {}}\n", "model"));
  const auto problem = open_problem(walked(0.06, -0.03));
  const SearchResult result = search(*problem, nominal, {}, [](const std::string&) {});
  ASSERT_TRUE(result.suggestion);
  EXPECT_LT(result.suggestion->error, 1.05);
  EXPECT_EQ(result.verdict, "unexplained_structure");
  // Down the slope: along x by 0.06 of the speed, along y by -0.03.
  EXPECT_THAT(
      result.suggestion->formula,
      ContainsRegex("vx: 0.0(59|6)[0-9]* [*] cos[(]theta[)] [*] sqrt[(]vx [*] vx [+] vy [*] "
                    "vy[)] - 0.0(29|3)[0-9]* [*] sin[(]theta[)]"));
}

}  // namespace
}  // namespace seam::measurement
