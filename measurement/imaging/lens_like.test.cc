// A lens in the place of another begins where the images are alike.
#include "measurement/imaging/lens_like.h"

#include <gtest/gtest.h>

#include <cmath>

#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/geometry.h"

namespace seam::measurement {
namespace {

effects::Model with(const std::string& lens, const std::vector<double>& values,
                    effects::Model model) {
  std::vector<effects::ParameterValue> set;
  for (const double value : values) set.push_back({.value = value});
  model.set(effects::find_effect(lens), std::move(set));
  return model;
}

TEST(LensLike, AFisheyeThatMapsAsAPinholeDoes) {
  const effects::Model plain = with("pinhole", {162, 162.5, 88.5, 71.5}, {});
  const auto fisheye = effects::find_effect("fisheye");
  const double corner_rad = std::atan(std::hypot(89.5 / 162, 72.5 / 162.5));
  const auto values = lens_like(plain, *fisheye, 178, 144, corner_rad);
  ASSERT_TRUE(values);
  const effects::Projection found(with("fisheye", *values, plain), 178, 144);
  const effects::Projection equidistant(with("fisheye", {0, 0, 0, 0}, plain), 178, 144);
  double untouched_px = 0;
  for (double angle = 0; angle < corner_rad; angle += 0.05) {
    for (const double side : {0.3, 2.0, 4.4}) {
      const Vec3 ray(std::tan(angle) * std::cos(side), std::tan(angle) * std::sin(side), 1);
      // The pinhole's own equation.
      const double u = 88.5 + 162 * ray.x, v = 71.5 + 162.5 * ray.y;
      const effects::ImagePoint there = found.project(ray), before = equidistant.project(ray);
      EXPECT_NEAR(there.u, u, 0.02) << angle;
      EXPECT_NEAR(there.v, v, 0.02) << angle;
      untouched_px = std::max(untouched_px, std::hypot(before.u - u, before.v - v));
    }
  }
  EXPECT_GT(untouched_px, 5);
}

// A rational lens goes whole where a polynomial comes in its place: (1 - 0.2 r2) / (1 + 0.1 r2) is
// 1 - 0.3 r2 + 0.03 r2^2 - 0.003 r2^3 ...
TEST(LensLike, APolynomialThatMapsAsARationalLensDoes) {
  const effects::Model plain = with("pinhole", {500, 500, 319.5, 239.5}, {});
  const effects::Model rational = with("rational_lens", {-0.2, 0, 0, 0.1, 0, 0}, plain);
  const auto values = lens_like(rational, *effects::find_effect("radial_polynomial"), 640, 480,
                                /*most_rad=*/0.6);
  ASSERT_TRUE(values);
  EXPECT_NEAR((*values)[0], -0.3, 2e-3);
  EXPECT_NEAR((*values)[1], 0.03, 5e-3);
}

TEST(LensLike, SplinesThatMapAsABarrelLensThatIsOffItsAxisDoes) {
  const effects::Model plain = with("pinhole", {500, 500, 319.5, 239.5}, {});
  const effects::Model barrel = with("tangential_distortion", {0.002, -0.001},
                                     with("radial_polynomial", {-0.3, 0.08, 0}, plain));
  const auto splines = effects::any_lens();
  const auto values = spline_lens_like(barrel, *splines, 640, 480);
  ASSERT_TRUE(values);
  // Without distortion 65.2 degrees from side to side; rows ask for more.
  EXPECT_GT((*values)[0], 65);
  EXPECT_LT((*values)[0], 100);
  const effects::Model found = with(splines->name, *values, plain);
  // What focal length, centre and poses would have to do is left.
  EXPECT_LT(lens_difference_px(barrel, found, 640, 480), 5);
  EXPECT_GT(lens_difference_px(barrel, plain, 640, 480), 10);
}

}  // namespace
}  // namespace seam::measurement
