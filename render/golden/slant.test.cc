// The slant of a vertical edge in a rolling frame, measured in rendered 8-bit frames, against the
// closed form of the head's chain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/renderer.h"
#include "render/test_scenes.h"

namespace seam::render {
namespace {

using namespace testing;

constexpr double kLever_m = 0.0666;
// The edge stands here; the wall reaches from it far to the left.
constexpr double kEdgeX_m = 1.1, kEdgeY_m = 0.08;

// Where the edge is seen when the head has turned to `pan`: the camera stands ahead of the pan
// axis, so both its direction and its place change.
double edge_column(double pan_rad) {
  const double forward = kEdgeX_m * std::cos(pan_rad) + kEdgeY_m * std::sin(pan_rad) - kLever_m;
  const double left = kEdgeY_m * std::cos(pan_rad) - kEdgeX_m * std::sin(pan_rad);
  return kCx - kFx * left / forward;
}

// The column at which each row's light falls from the wall's to the background's.
std::vector<double> measured_edge(double pan_rate, double line_delay_s, double exposure_s) {
  const effects::Model model = model_of(
      "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n  rolling_shutter: "
      "{line_delay_s: " +
      std::to_string(line_delay_s) + "}\n  exposure: {exposure_s: " + std::to_string(exposure_s) +
      "}\n");
  MovingScene scene;
  scene.background = {0, 0, 0};
  scene.camera = [=](double t_s) { return head_camera(0.2, pan_rate * (t_s - 0.02), 0, kLever_m); };
  scene.primitives = [](double) {
    // In the plane x = kEdgeX: normal along x, first side along y.
    const Mat3 facing(Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(1, 0, 0));
    return std::vector<Primitive>{{.shape = Shape::rectangle,
                                   .X_WO = {facing, {kEdgeX_m, kEdgeY_m + 2.5, 0.2}},
                                   .size = {5, 6, 0},
                                   .rgb = {0.8, 0.8, 0.8}}};
  };
  const Frame frame = Renderer(model, kWidth, kHeight).render(job_of(scene, model, kHeight, 0));
  std::vector<double> columns;
  for (int v = 0; v < kHeight; ++v) {
    double lit = 0;
    for (int u = 0; u < kWidth; ++u) lit += frame.rgb[3 * (v * kWidth + u) + 1] / 204.0;
    columns.push_back(lit - 0.5);
  }
  return columns;
}

TEST(Slant, RollingFrameShowsTheClosedFormOfTheHeadChain) {
  for (const double degrees_per_s : {30.0, 90.0, 172.5, 300.0}) {
    for (const double sign : {-1.0, 1.0}) {
      const double rate = sign * degrees_per_s * M_PI / 180;
      const std::vector<double> edge = measured_edge(rate, 2.78e-4, 0.005);
      double worst = 0;
      for (int v = 0; v < kHeight; ++v) {
        const double middle_s = 2.78e-4 * v + 0.0025;
        worst = std::max(worst, std::abs(edge[v] - edge_column(rate * (middle_s - 0.02))));
      }
      EXPECT_LT(worst, 0.25) << degrees_per_s * sign << " deg/s";
      std::printf("%6.1f deg/s: slant %7.2f px over the image, worst row off by %.3f px\n",
                  degrees_per_s * sign, edge.back() - edge.front(), worst);
    }
  }
}

TEST(Slant, NoLineDelayNoSlant) {
  for (const double rate : {-5.236, 5.236}) {
    const std::vector<double> edge = measured_edge(rate, 0, 0.005);
    const auto [low, high] = std::minmax_element(edge.begin(), edge.end());
    EXPECT_LT(*high - *low, 0.25);
    // Rows are sampled at places of their own; over thirds of the image that averages out.
    const double above = std::accumulate(edge.begin(), edge.begin() + 48, 0.0) / 48;
    const double below = std::accumulate(edge.end() - 48, edge.end(), 0.0) / 48;
    EXPECT_NEAR(above, below, 0.02);
    EXPECT_NEAR(above, edge_column(rate * (0.0025 - 0.02)), 0.05);
  }
}

// Rows exposed bottom first slant the other way.
TEST(Slant, NegativeLineDelayMirrorsTheSlant) {
  const std::vector<double> down = measured_edge(3, 2e-4, 0), up = measured_edge(3, -2e-4, 0);
  for (int v = 0; v < kHeight; v += 13) {
    EXPECT_NEAR(down[v], edge_column(3 * (2e-4 * v - 0.02)), 0.05);
    EXPECT_NEAR(up[v], edge_column(3 * (-2e-4 * v - 0.02)), 0.05);
  }
}

}  // namespace
}  // namespace seam::render
