// Depth and optical flow against closed forms.
#include "render/ground_truth.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/renderer.h"
#include "render/test_scenes.h"
#include "sim_core/base/error.h"

namespace seam::render {
namespace {

constexpr int kWidth_px = 60, kHeight_px = 48;
constexpr double kFocal_px = 55, kCx_px = 29.5, kCy_px = 23.5;
constexpr double kDelay_s = 3e-4, kExposure_s = 8e-3;

effects::Model rolling_model() {
  return testing::model_of(
      fmt::format("  pinhole: {{fx_px: {0}, fy_px: {0}, cx_px: {1}, cy_px: {2}}}\n"
                  "  rolling_shutter: {{line_delay_s: {3}}}\n  exposure: {{exposure_s: {4}}}\n",
                  kFocal_px, kCx_px, kCy_px, kDelay_s, kExposure_s));
}

GroundTruth truth_of(const testing::MovingScene& scene) {
  const effects::Model model = rolling_model();
  const Renderer renderer(model, kWidth_px, kHeight_px);
  return renderer.ground_truth(testing::job_of(scene, model, kHeight_px, 0.3));
}

// A wall 2 m ahead of a camera at the origin that looks along +x.
Primitive wall(double y_m = 0) {
  Primitive wall{.shape = Shape::box,
                 .X_WO = translation({2.5, y_m, 0}),
                 .size = {1, 20, 20},
                 .rgb = {1, 1, 1}};
  return wall;
}

// When row v (also between rows) begins its window, or ends it with `fraction` 1.
double window_s(double v, double fraction) {
  return 0.3 + kDelay_s * v + kExposure_s * fraction;
}

TEST(GroundTruth, FlowOfAPanningCameraIsTheHeadChainsInClosedForm) {
  for (const double rate : {-3.0, 0.8, 5.0}) {
    const GroundTruth truth = truth_of(
        {.camera = [&](double t) { return testing::head_camera(0, rate * (t - 0.3), 0, 0); },
         .primitives = [](double) { return std::vector{wall()}; }});
    double worst = 0;
    for (int v = 0; v < kHeight_px; ++v) {
      for (int u = 0; u < kWidth_px; ++u) {
        // The point seen at the window's middle, in the camera's axes then.
        const double x = (u - kCx_px) / kFocal_px, y = (v - kCy_px) / kFocal_px;
        const double seen_rad = rate * (window_s(v, 0.5) - 0.3);
        // By another pan angle its direction turns about the vertical; the row decides the time,
        // and the time the row.
        const auto position = [&](double fraction) {
          double pu = u, pv = v;
          for (int i = 0; i < 50; ++i) {
            const double turned = rate * (window_s(pv, fraction) - 0.3) - seen_rad;
            const double z = std::cos(turned) - x * std::sin(turned);
            pu = kCx_px + kFocal_px * (x * std::cos(turned) + std::sin(turned)) / z;
            pv = kCy_px + kFocal_px * y / z;
          }
          return std::pair(pu, pv);
        };
        const auto [u0, v0] = position(0);
        const auto [u1, v1] = position(1);
        const size_t i = static_cast<size_t>(v) * kWidth_px + u;
        // Beyond the image's first and last row there is no time to follow the point to.
        if (std::min(v0, v1) < 0 || std::max(v0, v1) > kHeight_px - 1) continue;
        worst = std::max({worst, std::abs(truth.flow_u_px[i] - (u1 - u0)),
                          std::abs(truth.flow_v_px[i] - (v1 - v0))});
      }
    }
    EXPECT_LT(worst, 0.01) << rate;
    // And it is the motion that it should be: the rate times the exposure, in the middle.
    EXPECT_NEAR(truth.flow_u_px[24 * kWidth_px + 30], kFocal_px * rate * kExposure_s,
                0.02 * std::abs(rate))
        << rate;
  }
}

TEST(GroundTruth, FlowAndDepthOfAMovingWallBeforeAStandingCamera) {
  constexpr double kSpeed_mps = 1.5;  // To the left, so that the image moves to smaller u.
  const GroundTruth truth =
      truth_of({.camera = [](double) { return testing::head_camera(0, 0, 0, 0); },
                .primitives = [](double t) { return std::vector{wall(kSpeed_mps * t)}; }});
  for (size_t i = 0; i < truth.depth_m.size(); ++i) {
    EXPECT_NEAR(truth.depth_m[i], 2, 1e-5);
    EXPECT_NEAR(truth.flow_u_px[i], -kFocal_px * kSpeed_mps * kExposure_s / 2, 1e-4);
    EXPECT_NEAR(truth.flow_v_px[i], 0, 1e-4);
  }
}

TEST(GroundTruth, ASphereIsAsDeepAsItsNearSideAndTheBackgroundHasNoFlow) {
  const double radius = 0.4, distance = 1.5;
  const GroundTruth truth =
      truth_of({.camera = [](double) { return testing::head_camera(0, 0, 0, 0); },
                .primitives =
                    [&](double) {
                      return std::vector{testing::sphere({distance, 0, 0}, radius, {1, 0, 0})};
                    }});
  int inside = 0;
  for (int v = 0; v < kHeight_px; ++v) {
    for (int u = 0; u < kWidth_px; ++u) {
      const size_t i = static_cast<size_t>(v) * kWidth_px + u;
      // z of |z (x, y, 1) - (0, 0, distance)| = radius, the nearer solution.
      const double x = (u - kCx_px) / kFocal_px, y = (v - kCy_px) / kFocal_px;
      const double square = 1 + x * x + y * y;
      const double root = distance * distance - square * (distance * distance - radius * radius);
      if (std::abs(root) < 1e-3) continue;  // The limb: rounding decides.
      if (root < 0) {
        EXPECT_TRUE(std::isinf(truth.depth_m[i]));
        EXPECT_EQ(truth.flow_u_px[i], 0);
        continue;
      }
      ++inside;
      EXPECT_NEAR(truth.depth_m[i], (distance - std::sqrt(root)) / square, 1e-4);
    }
  }
  EXPECT_GT(inside, 400);
}

TEST(GroundTruth, ACalibrationThatCannotBeInvertedNamesItsKey) {
  const effects::Model model = testing::model_of(
      "  pinhole: {fx_px: 55, fy_px: 55, cx_px: 29.5, cy_px: 23.5}\n  radial_polynomial: {k1: "
      "-2}\n");
  try {
    const Renderer renderer(model, kWidth_px, kHeight_px);
    FAIL() << "rays where none are";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("effects.radial_polynomial {k1: -2"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace seam::render
