// The filter over neighbours against plain loops, and its determinant against the whole matrix's.
#include "effects/stages/sensor/mixing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "effects/stages/sensor/sensor.h"

namespace seam::effects {
namespace {

constexpr double kAlong = 0.13, kAcross = -0.06;
constexpr Mixing kMixing{.along_rows = kAlong, .along_columns = kAcross};

// Each pixel from the nine about it; beyond the edges the last one stands once more.
std::vector<double> by_hand(const std::vector<float>& image, const ImageShape& shape) {
  std::vector<double> out;
  const auto share = [](double weight, int away) { return away == 0 ? 1 - 2 * weight : weight; };
  for (int v = 0; v < shape.height_px; ++v) {
    for (int u = 0; u < shape.width_px; ++u) {
      for (int c = 0; c < shape.channels; ++c) {
        double sum = 0;
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) {
            const int at_v = std::clamp(v + dv, 0, shape.height_px - 1),
                      at_u = std::clamp(u + du, 0, shape.width_px - 1);
            sum += share(kAcross, dv) * share(kAlong, du) *
                   image[static_cast<size_t>((at_v * shape.width_px + at_u) * shape.channels + c)];
          }
        }
        out.push_back(sum);
      }
    }
  }
  return out;
}

std::vector<float> normal_image(const ImageShape& shape) {
  const RandomStream stream{.seed = 5};
  std::vector<float> image;
  const int samples = shape.width_px * shape.height_px * shape.channels;
  for (int i = 0; i < samples; ++i)
    image.push_back(static_cast<float>(100 + 5 * normal(stream, static_cast<uint64_t>(i))));
  return image;
}

TEST(Mixing, IsTheSumOverNinePixelsAndIsUndone) {
  for (const ImageShape& shape : {ImageShape{7, 5, 1}, {6, 4, 3}, {1, 6, 1}, {9, 1, 1}}) {
    const std::vector<float> image = normal_image(shape);
    std::vector<float> mixed = image;
    mix(kMixing, shape, mixed);
    const std::vector<double> expected = by_hand(image, shape);
    for (size_t i = 0; i < image.size(); ++i) EXPECT_NEAR(mixed[i], expected[i], 2e-5);
    unmix(kMixing, shape, mixed);
    for (size_t i = 0; i < image.size(); ++i) EXPECT_NEAR(mixed[i], image[i], 2e-4);
  }
}

// Logarithm of the determinant, by Gaussian elimination.
double log_det(std::vector<std::vector<double>> matrix) {
  double sum = 0;
  for (size_t k = 0; k < matrix.size(); ++k) {
    sum += std::log(matrix[k][k]);
    for (size_t i = k + 1; i < matrix.size(); ++i) {
      const double share = matrix[i][k] / matrix[k][k];
      for (size_t j = k; j < matrix.size(); ++j) matrix[i][j] -= share * matrix[k][j];
    }
  }
  return sum;
}

TEST(Mixing, HasTheDeterminantOfItsMatrix) {
  const ImageShape shape{6, 4, 1};
  std::vector<std::vector<double>> matrix;
  for (size_t i = 0; i < 24; ++i) {
    std::vector<float> point(24, 0);
    point[i] = 1;
    matrix.push_back(by_hand(point, shape));
  }
  EXPECT_NEAR(log_mixing(kMixing, shape), log_det(matrix) / 24, 1e-9);
}

TEST(Mixing, IsKnownByTheCorrelationThatItMakes) {
  for (const double weight : {-0.1, 0.01, 0.1, 0.2})
    EXPECT_NEAR(mixing_of(mixed_correlation(weight)), weight, 1e-12);
  EXPECT_EQ(mixing_of(0), 0);
}

TEST(Mixing, LeavesAndReturnsTheVarianceThatItSays) {
  const ImageShape shape{400, 1, 1};
  std::vector<float> point(400, 0), back(400, 0);
  point[200] = back[200] = 1;
  mix(kMixing, shape, point);
  unmix(kMixing, shape, back);
  double mixed = 0, unmixed = 0, next = 0;
  for (size_t i = 0; i + 1 < 400; ++i) {
    mixed += point[i] * point[i];
    unmixed += back[i] * back[i], next += back[i] * back[i + 1];
  }
  // One row is the same across.
  EXPECT_NEAR(mixed, mixed_variance(kAlong), 1e-6);
  EXPECT_NEAR(unmixed, unmixed_variance(kAlong), 1e-5);
  EXPECT_NEAR(next / unmixed, unmixed_correlation(kAlong), 1e-5);
}

// Frames of a camera with the filter have the noise that its definition says.
TEST(Mixing, FramesAreMixedBeforeTheyAreRounded) {
  SensorChain chain;
  chain.gain_dn = 2000, chain.black_dn = 100, chain.electrons_per_dn = 2, chain.read_sigma_dn = 5;
  chain.mixing = kMixing;
  constexpr int kSide = 120;
  const RandomStream camera{.seed = 3};
  const FixedPattern pattern = fixed_pattern(chain, kSide, kSide, 1, camera);
  const std::vector<float> light(kSide * kSide, 0.5f);
  const SensorExposure exposure{.file_bits = 12};
  double sum = 0, square = 0, product = 0, n = 0;
  for (uint64_t frame = 0; frame < 10; ++frame) {
    const Image image = expose(chain, pattern, light, exposure, camera.child(frame));
    for (size_t i = 0; i + 1 < image.samples.size(); ++i) {
      const double here = image.samples[i] - 1100.0, next = image.samples[i + 1] - 1100.0;
      sum += here, square += here * here, product += here * next, ++n;
    }
  }
  const double variance =
      mixed_variance(kAlong) * mixed_variance(kAcross) * (1000 / 2.0 + 25) + 1 / 12.0;
  EXPECT_NEAR(sum / n, 0, 0.3);
  EXPECT_NEAR(square / n, variance, 0.03 * variance);
  EXPECT_NEAR(product / square, mixed_correlation(kAlong), 0.015);
  const Image mean = expose(chain, pattern, light, exposure, camera, false);
  EXPECT_EQ(mean.samples[kSide + 1], 1100);
}

}  // namespace
}  // namespace seam::effects
