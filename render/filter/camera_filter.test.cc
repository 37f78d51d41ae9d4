// The fused filters against their separate passes.
#include "render/filter/camera_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "render/filter/optics_filter.h"
#include "render/filter/point_spread.h"
#include "render/renderer.h"
#include "render/test_scenes.h"
#include "sim_core/base/error.h"

namespace seam::render {
namespace {

using namespace testing;

LinearImage random_image(int width, int height) {
  LinearImage image{.width_px = width, .height_px = height};
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < width * height; ++i) {
      image.planes[c].push_back(
          static_cast<float>(uniform({.seed = 4, .stream = static_cast<uint64_t>(c)}, i)));
    }
  }
  return image;
}

TEST(CameraFilter, FusedEqualsThePasses) {
  const effects::Model model = model_of(
      "  lens_blur: {sigma_px: 1.0}\n  vignetting: {a2: 0.3, a4: 0.1}\n  veiling_glare: {fraction: "
      "0.1}\n  amplifier_glow: {light: 0.3, fall_u_per_px: 0.1}\n");
  const effects::Optics optics = effects::optics_of(model);
  const effects::GainField gain(model, effects::Stage::radiometry, 40, 30);
  const CameraFilter filter(model, 40, 30);
  const LinearImage image = random_image(48, 38);
  std::vector<float> lamps;
  for (int v = 0; v < 30; ++v) lamps.push_back(1 + 0.01f * static_cast<float>(v));
  std::vector<float> fused;
  filter.apply(image, {}, lamps, fused);

  LinearImage passes = blurred(image, 4, point_spread(optics));
  scale_rows(passes, lamps);
  std::array<std::vector<float>, 3> planes;
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 40 * 30; ++i)
      planes[c].push_back(static_cast<float>(gain.at(i % 40, i / 40, 0, c)));
  }
  apply_gain(passes, planes);
  add_glare(passes, 0.1);
  const effects::OwnLight own(model, 40, 30);
  for (auto& plane : passes.planes) {
    for (int i = 0; i < 40 * 30; ++i) plane[i] += static_cast<float>(own.at(i % 40, i / 40));
  }
  for (size_t i = 0; i < fused.size(); ++i)
    EXPECT_NEAR(fused[i], passes.planes[i % 3][i / 3], 1e-5);
}

TEST(CameraFilter, NoOpticsIsTheImageItself) {
  const CameraFilter filter(model_of("  {}\n"), 8, 6);
  const LinearImage image = random_image(8, 6);
  std::vector<float> out;
  filter.apply(image, {}, std::vector<float>(6, 1.0f), out);
  for (size_t i = 0; i < out.size(); ++i) EXPECT_EQ(out[i], image.planes[i % 3][i / 3]);
}

TEST(PointSpread, HasTheGaussiansMoments) {
  for (const double sigma : {0.2, 0.5, 0.69, 0.71, 1.0, 2.5}) {
    const std::vector<float> weights = point_spread({.blur_sigma_px = sigma});
    const int radius = static_cast<int>(weights.size() / 2);
    double sum = 0, second = 0;
    for (int k = -radius; k <= radius; ++k)
      sum += weights[k + radius], second += k * k * weights[k + radius];
    EXPECT_NEAR(sum, 1, 1e-6);
    EXPECT_NEAR(second, sigma * sigma, 2e-3 * sigma * sigma) << sigma;
    const double least_radius = sigma >= kLeastSampledSigma_px ? 4 * sigma : 2;
    EXPECT_GE(radius, least_radius);
  }
  EXPECT_TRUE(point_spread({}).empty());
  EXPECT_EQ(point_spread({.blur_sigma_px = 1, .blur_window_px = 5}).size(),
            5u);  // The founding paper's.
}

// The image-space filter of the founding paper.
TEST(ImageFilter, FusedEqualsThePasses) {
  const effects::Model model = model_of(
      "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n  radial_distortion: "
      "{kappa: -0.05}\n"
      "  lens_blur: {sigma_px: 1.0, window_px: 5}\n  vignetting: {a2: 0.25, a4: 0.05}\n  "
      "read_noise: {sigma_dn: 2}\n");
  const ImageFilter filter(model, 178, 144, {.seed = 1, .stream = 1});
  const LinearImage ideal = random_image(178, 144);
  std::vector<uint8_t> fused, passes;
  const RandomStream noise{.seed = 1, .stream = 77};
  filter.apply(ideal, noise, fused);
  filter.apply_in_passes(ideal, noise, passes);
  ASSERT_EQ(fused.size(), passes.size());
  int differ = 0;
  for (size_t i = 0; i < fused.size(); ++i) {
    EXPECT_NEAR(fused[i], passes[i], 1);  // A value on the edge of rounding.
    differ += fused[i] != passes[i];
  }
  EXPECT_LT(differ, int(fused.size()) / 2000);
}

TEST(RayTable, CalibrationThatCannotBeInvertedIsNamed) {
  const effects::Model model = model_of(
      "  pinhole: {fx_px: 60, fy_px: 60, cx_px: 88.5, cy_px: 71.5}\n  radial_distortion: {kappa: "
      "0.9}\n");
  try {
    const Renderer renderer(model, 178, 144);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("model 'test'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("no ray leads to pixel"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace seam::render
