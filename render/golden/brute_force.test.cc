// Rendered noise-free frames against brute force (brute_force.h), in 8-bit DN.
#include "render/golden/brute_force.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "render/golden/moving_scenes.h"
#include "render/renderer.h"

namespace seam::render {
namespace {

using namespace testing;

BruteLens lens_of(const Case& c) {
  return {kFx, kFy, kCx, kCy, c.kappa};
}

struct Difference {
  double mean = 0, rms = 0, worst = 0, within_4 = 0;
};

int row_step() {
  const char* step = std::getenv("SEAM_REFERENCE_ROW_STEP");  // 1 compares whole frames.
  return step ? std::max(1, std::atoi(step)) : 16;
}

Difference compare(const Case& c, double sigma_px, int instants, const RendererOptions& options,
                   int rays) {
  const effects::Model model = model_for(c, sigma_px);
  const FrameJob job = job_of(c.scene, model, kHeight, 0, instants);
  const Renderer renderer(model, kWidth, kHeight, options);
  const LinearImage light = renderer.render_linear(job);
  Difference difference;
  size_t count = 0;
  for (int row = 5; row < kHeight; row += row_step()) {
    const RowWindow window = job.schedule.rows[row];
    const std::vector<Rgb> truth =
        sigma_px > 0
            ? brute_blurred_row(c.scene, lens_of(c), window, row, kWidth, sigma_px, 256, rays)
            : brute_row(c.scene, lens_of(c), window, row, kWidth, 0, 256, rays);
    for (int u = 0; u < kWidth; ++u) {
      for (int channel = 0; channel < 3; ++channel) {
        const double off =
            255 * std::abs(light.planes[channel][row * kWidth + u] - truth[u][channel]);
        difference.mean += off, difference.rms += off * off, ++count;
        difference.worst = std::max(difference.worst, off);
        difference.within_4 += off <= 4;
      }
    }
  }
  difference.mean /= double(count), difference.within_4 /= double(count);
  difference.rms = std::sqrt(difference.rms / double(count));
  std::printf(
      "%-22s blur %.0f px, %3d instants: mean %.3f DN, rms %.3f, worst %.1f, within 4 DN %.4f\n",
      c.name, sigma_px, instants, difference.mean, difference.rms, difference.worst,
      difference.within_4);
  return difference;
}

class BruteForce : public ::testing::TestWithParam<int> {};

TEST_P(BruteForce, DefaultAgreesBehindALensOfOnePixelBlur) {
  const Difference difference = compare(cases()[GetParam()], 1, 8, {}, 1);
  EXPECT_LT(difference.mean, 0.5);
  EXPECT_GE(difference.within_4, 0.999);
}

TEST_P(BruteForce, SharpLensConverges) {
  const Difference difference =
      compare(cases()[GetParam()], 0, 64, {.edge_samples_per_pixel = 2048}, 8);
  EXPECT_LT(difference.mean, 0.5);
  EXPECT_GE(difference.within_4, 0.999);
}

INSTANTIATE_TEST_SUITE_P(Scenes, BruteForce, ::testing::Range(0, 7));

TEST(BruteForceOrder, SharpErrorFallsWithTheInstants) {
  Case c = cases()[0];
  std::vector<double> rms;
  for (const int instants : {2, 4, 8}) {
    // Many samples at edges, and no instants of the renderer's own: the quadrature over time is
    // what is left.
    rms.push_back(
        compare(c, 0, instants, {.edge_samples_per_pixel = 2048, .max_motion_px = 100}, 8).rms);
  }
  // A box swept over an edge is a quadrature of first order at its ends and of second in between.
  EXPECT_LT(rms[1], rms[0] / 2);
  EXPECT_LT(rms[2], rms[1] / 2);
}

}  // namespace
}  // namespace seam::render
