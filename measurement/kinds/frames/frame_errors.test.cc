// Errors of whole images against dense linear algebra and against edges whose coverage is known.
#include "measurement/kinds/frames/frame_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr int kWidth = 8, kHeight = 6;
constexpr size_t kSamples = static_cast<size_t>(kWidth) * kHeight * 3;

// A step from 10 to 90 at column x (pixel borders are whole numbers), each pixel its average.
std::vector<float> step_image(double x) {
  std::vector<float> image(kSamples);
  for (size_t i = 0; i < kSamples; ++i) {
    const double u = static_cast<double>(i / 3 % kWidth);
    image[i] = static_cast<float>(10 + 80 * std::clamp(u + 1 - x, 0.0, 1.0));
  }
  return image;
}

TEST(ImageSlope, AnEdgeInsideAPixelMovesThatPixelByItsContrast) {
  for (const double x : {3.1, 3.5, 3.9, 4.25}) {
    const auto before = step_image(x), after = step_image(x - 1e-3);
    const ImageSlope slope = image_slope(before, kWidth, kHeight);
    for (size_t i = 0; i < kSamples; ++i) {
      // An image moved to the left by d is I(u + d).
      EXPECT_NEAR(slope.right[i], (after[i] - before[i]) / 1e-3, 0.05) << x << " sample " << i;
      EXPECT_EQ(slope.down[i], 0);
    }
  }
}

TEST(ImageSlope, ARampMovesByItsSlope) {
  std::vector<float> image(kSamples);
  for (size_t i = 0; i < kSamples; ++i) {
    image[i] =
        2.0f * static_cast<float>(i / 3 % kWidth) - 3.0f * static_cast<float>(i / 3 / kWidth);
  }
  const ImageSlope slope = image_slope(image, kWidth, kHeight);
  for (int v = 1; v + 1 < kHeight; ++v) {
    for (int u = 1; u + 1 < kWidth; ++u) {
      const size_t i = (static_cast<size_t>(v) * kWidth + u) * 3;
      EXPECT_NEAR(slope.right[i], 2, u > 1 && u + 2 < kWidth ? 1e-5 : 1);
      EXPECT_NEAR(slope.down[i], -3, v > 1 && v + 2 < kHeight ? 1e-5 : 1.5);
    }
  }
}

TEST(ImageSlope, NearbyIsTheSteepestOfNineNeighbours) {
  const ImageSlope slope = image_slope(step_image(4.5), kWidth, kHeight);
  const auto square = steepest_nearby(slope, kWidth, kHeight);
  for (size_t i = 0; i < kSamples; ++i) {
    const int u = static_cast<int>(i / 3 % kWidth);
    EXPECT_NEAR(square[i], std::abs(u - 4) <= 1 ? 6400 : 0, 1) << u;
  }
}

// The quadratic form of whitened values is that of the whole covariance, built densely.
TEST(FrameErrors, WhitenAsTheDenseCovarianceDoes) {
  const RandomStream stream{7, 1};
  std::vector<char> used(2 * kSamples, 1);
  used[5] = 0;
  std::vector<ImageSlope> slopes(2);
  for (size_t k = 0; k < 2; ++k) {
    for (size_t i = 0; i < kSamples; ++i) {
      slopes[k].right.push_back(static_cast<float>(400 * normal(stream, 4 * i + 2 * k)));
      slopes[k].down.push_back(static_cast<float>(300 * normal(stream, 4 * i + 2 * k + 1)));
    }
  }
  const FrameErrors errors(kWidth, kHeight, {}, slopes, used,
                           std::vector<double>(2 * kSamples, 1.5));

  const auto n = static_cast<Eigen::Index>(2 * kSamples);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd common[2] = {Eigen::VectorXd::Zero(n), Eigen::VectorXd::Zero(n)};
  for (size_t k = 0; k < 2; ++k) {
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n), down = right;
    for (size_t i = 0; i < kSamples; ++i) {
      const auto at = static_cast<Eigen::Index>(k * kSamples + i);
      const double weight = used[k * kSamples + i] / 1.5;
      right[at] = slopes[k].right[i] * weight, down[at] = slopes[k].down[i] * weight;
    }
    down -= right * (right.dot(down) / right.squaredNorm());
    for (const auto& d : {right, down})
      covariance += kRendererShiftPx * kRendererShiftPx * d * d.transpose();
    common[0] += right, common[1] += down;
  }
  for (const auto& d : common)
    covariance += kRendererShiftPx * kRendererShiftPx * d * d.transpose();

  std::vector<double> values(2 * kSamples, 0);
  Eigen::VectorXd dense(n);
  for (size_t k = 0; k < 2; ++k) {
    for (size_t i = 0; i < kSamples; ++i) {
      const size_t at = k * kSamples + i;
      values[at] = used[at] ? normal(stream, 100'000 + at) + 0.1 * slopes[k].right[i] / 1.5 : 0;
      dense[static_cast<Eigen::Index>(k * kSamples + i)] = values[at];
    }
  }
  errors.whiten(values);
  double whitened = 0;
  for (const double value : values) whitened += value * value;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  EXPECT_NEAR(whitened, dense.dot(factor.solve(dense)), 1e-6 * whitened);
  const double log_det = 2 * Eigen::MatrixXd(factor.matrixL()).diagonal().array().log().sum();
  EXPECT_NEAR(errors.log_det(0) + errors.log_det(1), log_det, 1e-4);
}

}  // namespace
}  // namespace seam::measurement
