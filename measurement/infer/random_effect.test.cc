#include "measurement/infer/random_effect.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

struct Data {
  Eigen::MatrixXd columns;
  Eigen::VectorXd residuals;
};

Data drawn(double size, uint64_t seed) {
  Data data{Eigen::MatrixXd(60, 7), Eigen::VectorXd(60)};
  const auto draw = [&](uint64_t stream, uint64_t index) { return normal({seed, stream}, index); };
  Eigen::VectorXd b(7);
  for (Eigen::Index k = 0; k < 7; ++k) {
    b[k] = size * draw(1, static_cast<uint64_t>(k));
    for (Eigen::Index i = 0; i < 60; ++i)
      data.columns(i, k) = draw(2 + static_cast<uint64_t>(k), static_cast<uint64_t>(i));
  }
  for (Eigen::Index i = 0; i < 60; ++i) data.residuals[i] = draw(20, static_cast<uint64_t>(i));
  data.residuals += data.columns * b;
  return data;
}

RandomEffect effect_of(const Data& data) {
  return random_effect(data.columns.transpose() * data.columns,
                       data.columns.transpose() * data.residuals);
}

// ln of the normal density of the residuals with covariance 1 + size^2 columns columns', but for a
// constant.
double log_density(const Data& data, double size) {
  const Eigen::Index n = data.residuals.size();
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::Identity(n, n) + size * size * data.columns * data.columns.transpose();
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  const Eigen::MatrixXd lower = root.matrixL();
  return -0.5 * data.residuals.dot(root.solve(data.residuals)) -
         lower.diagonal().array().log().sum();
}

TEST(RandomEffect, GainIsTheRatioOfTheNormalDensities) {
  const Data data = drawn(0.4, 3);
  const RandomEffect effect = effect_of(data);
  ASSERT_GT(effect.size, 0);
  EXPECT_NEAR(effect.log_evidence, log_density(data, effect.size) - log_density(data, 0), 1e-6);
}

// Columns that differ by rounding alone tell no size: what they seem to gain is not there.
TEST(RandomEffect, GainsNoMoreThanItTakesFromTheResiduals) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Data data = drawn(1000, seed);
    for (Eigen::Index i = 0; i < 60; ++i) {
      for (Eigen::Index k = 1; k < 7; ++k)
        data.columns(i, k) = data.columns(i, 0) * (1 + 1e-9 * data.columns(i, k));
      data.residuals[i] += 1000 * normal({seed, 40}, static_cast<uint64_t>(i));
    }
    const RandomEffect effect = effect_of(data);
    const double taken =
        0.5 * (data.residuals.squaredNorm() -
               (data.residuals - data.columns * effect.coefficients).squaredNorm());
    EXPECT_LE(effect.log_evidence, taken * (1 + 1e-6)) << seed;
  }
}

TEST(RandomEffect, ItsSizeIsTheLikeliest) {
  const Data data = drawn(0.4, 4);
  const RandomEffect effect = effect_of(data);
  for (double factor = 0.05; factor < 20; factor *= 1.1)
    EXPECT_LE(log_density(data, factor * effect.size), log_density(data, effect.size) + 1e-3);
  EXPECT_GT(effect.size, 0.15);
  EXPECT_LT(effect.size, 1);
}

TEST(RandomEffect, NoiseAloneGainsNextToNothing) {
  double sum = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) sum += effect_of(drawn(0, seed)).log_evidence;
  EXPECT_LT(sum / 100, 0.5);
}

TEST(RandomEffect, CoefficientsAreTheMeanGivenTheData) {
  const Data data = drawn(0.4, 5);
  const RandomEffect effect = effect_of(data);
  // Of jointly normal b and r: cov(b, r) var(r)^-1 r.
  const double variance = effect.size * effect.size;
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::Identity(60, 60) + variance * data.columns * data.columns.transpose();
  const Eigen::VectorXd mean = variance * data.columns.transpose() *
                               Eigen::LLT<Eigen::MatrixXd>(covariance).solve(data.residuals);
  EXPECT_LT((mean - effect.coefficients).norm(), 1e-8 * mean.norm());
}

}  // namespace
}  // namespace seam::measurement
