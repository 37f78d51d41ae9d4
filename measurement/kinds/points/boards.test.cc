// A board before a fixed camera whose poses nobody knows: a fisheye lens is found although the
// perspective model, bent to the same points, ends far from it. The points come from the lens's
// formula, written out here.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/search/search.h"
#include "sim_core/base/output.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr double kFocal_px = 400, kCx_px = 645, kCy_px = 392;
constexpr double kNoise_px = 0.2;

// The angle from the axis goes to a radius by Kannala and Brandt's polynomial.
struct Pixel {
  double u_px, v_px;
};
Pixel fisheye(double x, double y, double z) {
  const double r = std::hypot(x, y), theta = std::atan2(r, z), t2 = theta * theta;
  const double bent = theta * (1 + t2 * (-0.04 + t2 * (-0.002 + t2 * 0.0005)));
  const double scale = r > 0 ? bent / r : 1 / z;
  return {kFocal_px * x * scale + kCx_px, kFocal_px * y * scale + kCy_px};
}

// Views of a board of 9 x 7 corners, turned by up to 30 degrees, all over a wide image.
std::filesystem::path board_views() {
  const auto folder = std::filesystem::path(testing::TempDir()) / "fisheye-board";
  std::filesystem::create_directories(folder);
  std::string rows = "frame,time_s,point,x_m,y_m,z_m,u_px,v_px\n";
  uint64_t draw = 0;
  const auto within = [&](double limit) { return limit * (2 * uniform({11, 1}, draw++) - 1); };
  for (int frame = 0; frame < 16; ++frame) {
    const double yaw = within(0.5), pitch = within(0.5), roll = within(0.6);
    const double cx = 0.45 * (frame % 4 - 1.5), cy = 0.3 * (frame / 4 - 1.5),
                 cz = 0.45 + within(0.1);
    for (int point = 0; point < 63; ++point) {
      const double a = 0.04 * (point % 9 - 4), b = 0.04 * (point / 9 - 3);
      const double x = std::cos(roll) * a - std::sin(roll) * b,
                   y = std::sin(roll) * a + std::cos(roll) * b;
      const double y2 = std::cos(pitch) * y, z2 = std::sin(pitch) * y;
      const double x3 = std::cos(yaw) * x + std::sin(yaw) * z2,
                   z3 = -std::sin(yaw) * x + std::cos(yaw) * z2;
      const Pixel seen = fisheye(x3 + cx, y2 + cy, z3 + cz);
      if (seen.u_px < 0 || seen.v_px < 0 || seen.u_px > 1279 || seen.v_px > 799) continue;
      const double noise_u = normal({11, 2}, 2 * draw), noise_v = normal({11, 2}, 2 * draw++ + 1);
      rows += fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", frame, frame, point, a, b,
                          seen.u_px + kNoise_px * noise_u, seen.v_px + kNoise_px * noise_v);
    }
  }
  write_file_atomically(folder / "points.csv", rows);
  write_file_atomically(
      folder / "measurement.yaml",
      "format: seam-measurement/1\nkind: points\ncamera: {width_px: 1280, height_px: 800}\n"
      "group: frame\nfiles: {points: points.csv}\nrig: {pose: unknown}\n");
  return folder;
}

TEST(Boards, AFisheyeLensIsFoundAndItsStepShown) {
  const auto problem = open_problem(board_views());
  const Model nominal = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 420, free: true}, fy_px: {value: "
      "420, free: true}, "
      "cx_px: {value: 639.5, free: true}, cy_px: {value: 399.5, free: true}}}\n",
      "test.yaml"));
  const SearchResult result = search(*problem, nominal, {}, [](const std::string&) {});
  ASSERT_EQ(result.steps.size(), 1u);
  EXPECT_EQ(result.steps[0].effect, "fisheye");
  EXPECT_GT(result.steps[0].error_before, 10);
  const Model& found = result.best.assessment.model;
  EXPECT_NEAR(found.find("fisheye")->value("k1"), -0.04, 0.01);
  EXPECT_NEAR(found.find("pinhole")->value("fx_px"), kFocal_px, 2);
  EXPECT_NEAR(found.find("pinhole")->value("cx_px"), kCx_px, 2);
  for (const double rms_px : result.best.assessment.held.native)
    EXPECT_NEAR(rms_px, kNoise_px, 0.03);
}

}  // namespace
}  // namespace seam::measurement
