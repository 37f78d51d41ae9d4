#include "app/import/pictures/scatter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::app {
namespace {

// A board of 9 x 6 corners, tilted to all sides before a lens that bends by 10 % at the image's
// corners.
std::vector<SeenView> tilted_views(double noise_px) {
  std::vector<SeenView> views;
  uint64_t drawn = 0;
  const auto noise = [&] { return noise_px * normal(RandomStream{42, 7}, drawn++); };
  for (int number = 0; number < 14; ++number) {
    const double turn = 2.4 * number, tilt = 0.65;
    const double x = std::cos(turn), y = std::sin(turn), c = std::cos(tilt), s = std::sin(tilt);
    SeenView view;
    for (size_t point = 0; point < 54; ++point) {
      const double a = 0.03 * (static_cast<double>(point % 9) - 4);
      const double b = 0.03 * (static_cast<double>(point / 9) - 2.5);
      const double along = x * a + y * b;
      const double px = a + (c - 1) * along * x, py = b + (c - 1) * along * y,
                   pz = 0.36 + s * along;
      const double u = px / pz, v = py / pz, r2 = u * u + v * v;
      const double bent = 1 - 0.3 * r2 + 0.12 * r2 * r2;
      view.corners.push_back({.point = point,
                              .p_W = Vec3(a, b, 0.0),
                              .u_px = 320 + 530 * u * bent + noise(),
                              .v_px = 240 + 530 * v * bent + noise()});
    }
    views.push_back(std::move(view));
  }
  return views;
}

TEST(Scatter, ALensBeforeATiltedTargetIsNoScatter) {
  for (const double noise_px : {0.05, 0.2}) {
    const Scatter scatter = scatter_of(tilted_views(noise_px));
    EXPECT_NEAR(scatter.all_px, noise_px, 0.15 * noise_px);
    for (const double view_px : scatter.view_px) EXPECT_NEAR(view_px, noise_px, 0.4 * noise_px);
  }
}

}  // namespace
}  // namespace seam::app
