// Errors of means over cells against the covariance of every value, written out.
#include "measurement/kinds/photometry/means/mean_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr int kWidth = 6, kHeight = 4, kChannels = 2;
// Two levels of light, the second's light not given.
const std::vector<int> kLevelOfFrame = {0, 1, 1, 0, 1};
constexpr double kNoise[] = {3, 4}, kOffset[] = {1, 0.8}, kLight[] = {0, 90}, kDark_s[] = {0.5, 2};

effects::SensorChain chain() {
  effects::SensorChain chain;
  chain.pixel_offset_sigma_dn = 2;
  chain.pixel_gain_sigma = 0.03;
  chain.dark_sigma_dn_per_s = 1.1;
  chain.column_sigma_dn = 1.5;
  chain.row_sigma_dn = 1.2;
  chain.lamp_sigma = 0.02;
  return chain;
}

struct Value {
  int frame, level, u, v, c;
};

std::vector<Value> values() {
  std::vector<Value> all;
  for (int f = 0; f < static_cast<int>(kLevelOfFrame.size()); ++f) {
    for (int v = 0; v < kHeight; ++v) {
      for (int u = 0; u < kWidth; ++u) {
        for (int c = 0; c < kChannels; ++c)
          all.push_back({f, kLevelOfFrame[static_cast<size_t>(f)], u, v, c});
      }
    }
  }
  return all;
}

// What two values' errors have in common; `share`: rows and columns do so across channels.
double covariance(const Value& a, const Value& b, bool share) {
  const effects::SensorChain sensor = chain();
  const double offset = kOffset[a.level] * kOffset[b.level],
               light = kLight[a.level] * kLight[b.level];
  const bool frame = a.frame == b.frame, row = a.v == b.v, column = a.u == b.u,
             channel = a.c == b.c;
  const bool sample = row && column && channel, unit = share || channel;
  double sum = 0;
  if (frame && sample) sum += kNoise[a.level] * kNoise[a.level];
  if (sample) sum += std::pow(sensor.pixel_offset_sigma_dn, 2) * offset;
  if (sample) sum += std::pow(sensor.pixel_gain_sigma, 2) * light;
  if (sample)
    sum += std::pow(sensor.dark_sigma_dn_per_s, 2) * kDark_s[a.level] * kDark_s[b.level] * offset;
  if (column && unit) sum += std::pow(sensor.column_sigma_dn, 2) * offset;
  if (frame && row && unit) sum += std::pow(sensor.row_sigma_dn, 2) * offset;
  if (frame) sum += std::pow(sensor.lamp_sigma, 2) * light;
  // Light that nothing is known of may be off by all of it.
  if (a.level == 1 && b.level == 1) sum += light;
  return sum;
}

TEST(MeanErrors, WhitenedMeansAreIndependentAndOfUnitSize) {
  PhotometryData data{.width_px = kWidth, .height_px = kHeight, .channels = kChannels};
  const ImageCells cells(data, {3, 2});
  const std::vector<Value> all = values();
  const Index means = cells.count(), frames = static_cast<Index>(kLevelOfFrame.size());
  ASSERT_EQ(means, 12);
  MatrixXd average = MatrixXd::Zero(means * frames, static_cast<Index>(all.size()));
  for (size_t i = 0; i < all.size(); ++i) {
    const Value& value = all[i];
    const Index cell = (value.v / 2 * 3 + value.u / 2) * kChannels + value.c;
    average(value.frame * means + cell, static_cast<Index>(i)) = 1 / 4.0;
  }
  for (const bool share : {true, false}) {
    std::vector<LevelMeans> levels;
    for (const int level : {0, 1}) {
      const auto same = [&](double value) {
        return Eigen::VectorXd::Constant(means, value).eval();
      };
      levels.push_back({.mean = same(100),
                        .offset_slope = same(kOffset[level]),
                        .gain_slope = same(kLight[level]),
                        .values = same(4),
                        .sigma = same(kNoise[level] / 2),
                        .dark_s = kDark_s[level]});
    }
    const MeanErrors errors(cells, chain(), levels, kLevelOfFrame, share, {0, 1});
    MatrixXd of_values(average.cols(), average.cols());
    for (size_t a = 0; a < all.size(); ++a) {
      for (size_t b = 0; b < all.size(); ++b)
        of_values(static_cast<Index>(a), static_cast<Index>(b)) = covariance(all[a], all[b], share);
    }
    const MatrixXd of_means = average * of_values * average.transpose();
    const MatrixXd half = errors.whitened(of_means);
    const MatrixXd white = errors.whitened(half.transpose());
    const MatrixXd one = MatrixXd::Identity(white.rows(), white.cols());
    EXPECT_LT((white - one).cwiseAbs().maxCoeff(), 1e-6) << share;
  }
}

TEST(MeanErrors, AMeanThatIsLeftOutHasNoPartInOthers) {
  PhotometryData data{.width_px = kWidth, .height_px = kHeight};
  const ImageCells cells(data, {3, 2});
  const auto same = [&](double value) { return Eigen::VectorXd::Constant(6, value).eval(); };
  LevelMeans level{.mean = same(100),
                   .offset_slope = same(1),
                   .gain_slope = same(90),
                   .values = same(4),
                   .sigma = same(2)};
  level.sigma[4] = 0;
  const MeanErrors errors(cells, chain(), {level}, {0, 0}, true, {0});
  MatrixXd columns = MatrixXd::Zero(12, 1);
  columns(4, 0) = 1000, columns(10, 0) = -500;
  EXPECT_EQ(errors.whitened(columns).norm(), 0);
}

}  // namespace
}  // namespace seam::measurement
