// A lens that folds the image over, or has a pole in it, is said to do so; what a camera is, as
// figures.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/views_testing.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr const char* kPinhole = "pinhole: {fx_px: 600, fy_px: 600, cx_px: 319.5, cy_px: 239.5}";
// (1 - 6.9 r^4) / (1 - 7 r^4): its pole is at r = 0.6148, 369 px from the centre, and the corners
// are 400 px away. No point of the set stands farther out than 360 px.
constexpr const char* kPole = ", rational_lens: {k2: -6.9, k5: -7.0}";

Model model_of(const std::string& more) {
  return Model::from_config(ConfigNode::from_text(
      fmt::format("format: seam-model/1\neffects: {{{}{}}}\n", kPinhole, more), "model"));
}

// Views of a board by a camera whose focal length is another one in each.
std::filesystem::path made() {
  std::string rows;
  for (int frame = 0; frame < 16; ++frame) {
    const double around = 2.4 * frame, tilt = 0.5 * (frame % 3 == 0 ? 0.4 : 1);
    const double yaw = tilt * std::cos(around), pitch = tilt * std::sin(around);
    const double f_px = 600 * (1 + 0.015 * std::sin(1.7 * frame));
    for (int point = 0; point < 54; ++point) {
      const double a = 0.03 * (point % 9 - 4), b = 0.03 * (point / 9 - 2.5);
      const double y = std::cos(pitch) * b, z2 = std::sin(pitch) * b;
      const double x = std::cos(yaw) * a + std::sin(yaw) * z2,
                   z = -std::sin(yaw) * a + std::cos(yaw) * z2 + 0.4;
      const auto noise = [&](int channel) {
        return 0.1 * normal({3, 5}, static_cast<uint64_t>(2 * (54 * frame + point) + channel));
      };
      const double u = f_px * (x + 0.05 * (frame % 3 - 1)) / z + 319.5 + noise(0);
      const double v = f_px * (y + 0.03 * (frame % 2)) / z + 239.5 + noise(1);
      if (std::hypot(u - 319.5, v - 239.5) > 360 || u < 0 || v < 0 || u > 639 || v > 479) continue;
      rows +=
          fmt::format("{},{},{},{:.4f},{:.4f},0,{:.4f},{:.4f}\n", frame, frame, point, a, b, u, v);
    }
  }
  return write_views("one-to-one", rows);
}

TEST(OneToOne, ALensWithAPoleInItsImageIsSaid) {
  const auto problem = open_problem(made());
  problem->prepare(model_of(kPole));
  EXPECT_TRUE(problem->evaluate(model_of(kPole), problem->all_groups()).valid);
  EXPECT_THAT(problem->remarks(model_of(kPole)), testing::Contains(testing::HasSubstr("pole")));
}

TEST(OneToOne, FocalLengthsAndCentreAreFigures) {
  const auto problem = open_problem(made());
  const auto figures =
      problem->figures(model_of(", principal_point_offset: {du_px: 2, dv_px: -1}"));
  ASSERT_EQ(figures.size(), 4u);
  EXPECT_EQ(figures[0].name, "focal length x");
  EXPECT_DOUBLE_EQ(figures[0].value, 600);
  EXPECT_DOUBLE_EQ(figures[2].value, 321.5);
  EXPECT_DOUBLE_EQ(figures[3].value, 238.5);
}

}  // namespace
}  // namespace seam::measurement
