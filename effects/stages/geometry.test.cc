#include "effects/stages/geometry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

Model model_of(const std::string& effects) {
  return Model::from_config(
      ConfigNode::from_text("format: seam-model/1\neffects:\n" + effects, "test.yaml"));
}

TEST(Projection, PinholeIsTheClosedForm) {
  const Projection camera(model_of("  pinhole: {fx_px: 160, fy_px: 162, cx_px: 88.5, cy_px: 71.5}"),
                          178, 144);
  const ImagePoint point = camera.project({0.2, -0.1, 2.0});
  EXPECT_TRUE(point.visible);
  EXPECT_DOUBLE_EQ(point.u, 160 * 0.1 + 88.5);
  EXPECT_DOUBLE_EQ(point.v, 162 * -0.05 + 71.5);
  EXPECT_FALSE(camera.project({0.2, -0.1, -2.0}).visible);
}

TEST(Projection, UnprojectInvertsDistortion) {
  const Projection camera(model_of("  pinhole: {fx_px: 160, fy_px: 162, cx_px: 88.5, cy_px: 71.5}\n"
                                   "  radial_distortion: {kappa: -0.4}"),
                          178, 144);
  for (double u : {0.0, 50.0, 177.0}) {
    for (double v : {0.0, 71.5, 143.0}) {
      const auto ray = camera.unproject(u, v);
      ASSERT_TRUE(ray.has_value());
      const ImagePoint back = camera.project(*ray);
      EXPECT_NEAR(back.u, u, 1e-8);
      EXPECT_NEAR(back.v, v, 1e-8);
    }
  }
}

constexpr const char* kSplines =
    "  pinhole: {fx_px: 160, fy_px: 160, cx_px: 88.5, cy_px: 71.5}\n"
    "  spline_lens: {fov_x_deg: 60, x_1_1: -0.02, y_1_1: 0.03, x_2_3: 0.01, y_4_5: -0.02, x_5_6: "
    "0.05}";

TEST(Projection, ALensOfSplinesIsInvertedOverTheImage) {
  const Projection camera(model_of(kSplines), 178, 144);
  for (double u = 0; u < 178; u += 8.85) {
    for (double v = 0; v < 144; v += 7.15) {
      const auto ray = camera.unproject(u, v);
      ASSERT_TRUE(ray.has_value()) << u << " " << v;
      const ImagePoint back = camera.project(*ray);
      EXPECT_NEAR(back.u, u, 1e-8);
      EXPECT_NEAR(back.v, v, 1e-8);
    }
  }
  // Far beyond its control points, and behind the camera, there is no image.
  EXPECT_FALSE(camera.project({3, 0, 1}).visible);
  EXPECT_FALSE(camera.project({0, 0, -1}).visible);
}

TEST(Projection, WhereALensOfSplinesFoldsAPointHasTheImageOfTheFold) {
  const Projection camera(model_of("  pinhole: {fx_px: 160, fy_px: 160, cx_px: 0, cy_px: 0}\n"
                                   "  spline_lens: {fov_x_deg: 120, x_2_5: -0.9, x_3_5: -0.9}"),
                          178, 144);
  double last_px = 0;
  int folded = 0;
  for (double angle = 0.01; angle < 1; angle += 0.01) {
    const ImagePoint point = camera.project({std::sin(angle), 0, std::cos(angle)});
    EXPECT_NE(point.visible, point.at_edge) << angle;
    if (point.visible && folded == 0) last_px = point.u;
    if (!point.at_edge) continue;
    ++folded;
    EXPECT_NEAR(point.u, last_px, 1.0) << angle;
  }
  EXPECT_GT(folded, 5);
}

TEST(Projection, ALensOfSplinesStandsBesideNoOtherLens) {
  for (const char* other : {"fisheye: {k1: 0.1}", "radial_polynomial: {k1: -0.2}",
                            "tangential_distortion: {p1: 0.01}", "thin_prism: {s1: 0.01}"}) {
    EXPECT_THROW(model_of(std::string(kSplines) + "\n  " + other), InputError) << other;
  }
}

// What a fit can follow: no point jumps out of the image where a lens folds it over.
TEST(Projection, BeyondAFoldAPointHasTheImageOfTheFold) {
  for (const char* lens : {"fisheye: {k1: -0.2}", "radial_polynomial: {k1: -0.2}",
                           "rational_lens: {k4: 0.4}", "radial_distortion: {kappa: 0.1}"}) {
    const Projection camera(
        model_of(std::string("  pinhole: {fx_px: 160, fy_px: 160, cx_px: 0, cy_px: 0}\n  ") + lens),
        178, 144);
    double before = 0;
    int folds = 0;
    for (double angle = 0.01; angle < 1.5; angle += 0.01) {
      const ImagePoint point = camera.project({std::sin(angle), 0, std::cos(angle)});
      EXPECT_NE(point.visible, point.at_edge) << lens << " at " << angle;
      EXPECT_GE(point.u, before - 1e-9) << lens << " at " << angle;
      if (point.at_edge && folds++ > 0) {
        EXPECT_NEAR(point.u, before, 1e-6) << lens << " at " << angle;
      }
      before = point.u;
    }
    EXPECT_GT(folds, 5) << lens;
    EXPECT_FALSE(camera.project({0.1, 0, -1}).visible) << lens;
  }
}

TEST(Model, FileRoundTripKeepsEverything) {
  const Model model = model_of(
      "  pinhole: {fx_px: {value: 160, free: true}, fy_px: 162, cx_px: 88.5, cy_px: 71.5}\n"
      "  rolling_shutter: {line_delay_s: {value: 2.41e-4, sigma: 1.2e-6}}");
  const std::string yaml = model.to_yaml();
  EXPECT_EQ(Model::from_config(ConfigNode::from_text(yaml, "again")).to_yaml(), yaml);
  EXPECT_EQ(model.effects().front().definition->name, "rolling_shutter");
}

TEST(Model, UnknownNamesAreSuggested) {
  try {
    model_of("  rolling_shuter: {line_delay_s: 1e-4}");
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean 'rolling_shutter'"), std::string::npos)
        << error.what();
  }
  EXPECT_ANY_THROW(model_of("  rolling_shutter: {line_delay: 1e-4}"));
  EXPECT_ANY_THROW(model_of("  rolling_shutter: {line_delay_s: 1e9}"));
}

}  // namespace
}  // namespace seam::effects
