// Whitening with common causes against dense linear algebra.
#include "measurement/noise/low_rank.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// S = D + U U' as a full matrix: chi-square and log det as its factors give them.
TEST(LowRank, ChiSquareAndDeterminantAreTheDenseOnes) {
  constexpr Eigen::Index kScalars = 14, kCauses = 3;
  const RandomStream stream{.seed = 12};
  uint64_t next = 0;
  const auto draw = [&] { return normal(stream, next++); };
  Eigen::MatrixXd causes(kScalars, kCauses);
  for (Eigen::Index i = 0; i < kScalars; ++i) {
    for (Eigen::Index c = 0; c < kCauses; ++c) causes(i, c) = draw() * (c == 1 ? 30 : 0.3);
  }
  causes.col(2) = 2 * causes.col(0);  // A cause told twice.
  // Two scalars beside these belong to no cause and stay.
  std::vector<size_t> scalars;
  Evaluation evaluation;
  for (size_t i = 0; i < kScalars + 2; ++i) {
    evaluation.sigma.push_back(0.1 + 0.05 * static_cast<double>(i));
    evaluation.residual.push_back(3 * draw());
    evaluation.whitened.push_back(evaluation.residual[i] / evaluation.sigma[i]);
    if (i != 4 && i != 9) scalars.push_back(i);
  }
  evaluation.log_det = {7, 0};
  Eigen::VectorXd r(kScalars);
  Eigen::MatrixXd s = causes * causes.transpose();
  for (Eigen::Index k = 0; k < kScalars; ++k) {
    const size_t i = scalars[static_cast<size_t>(k)];
    r[k] = evaluation.residual[i];
    s(k, k) += evaluation.sigma[i] * evaluation.sigma[i];
    evaluation.log_det[1] += 2 * std::log(evaluation.sigma[i]);
  }
  const double untouched = evaluation.whitened[9];

  whiten_low_rank(scalars, causes, 1, evaluation);

  double chi2 = 0;
  for (const size_t i : scalars) chi2 += evaluation.whitened[i] * evaluation.whitened[i];
  const Eigen::LLT<Eigen::MatrixXd> dense(s);
  EXPECT_NEAR(chi2 / r.dot(dense.solve(r)), 1, 1e-10);
  EXPECT_NEAR(evaluation.log_det[1],
              2 * Eigen::MatrixXd(dense.matrixL()).diagonal().array().log().sum(), 1e-9);
  for (Eigen::Index k = 0; k < kScalars; ++k)
    EXPECT_NEAR(evaluation.sigma[scalars[static_cast<size_t>(k)]], std::sqrt(s(k, k)), 1e-12);
  EXPECT_EQ(evaluation.log_det[0], 7);
  EXPECT_EQ(evaluation.whitened[9], untouched);
}

// The whitened residuals are a linear map of the residuals whose square is the inverse of S.
TEST(LowRank, TheMapIsARootOfTheInverse) {
  constexpr size_t kScalars = 5;
  Eigen::MatrixXd causes(kScalars, 1);
  causes << 1, -2, 0.5, 3, 0;
  std::vector<size_t> scalars;
  for (size_t i = 0; i < kScalars; ++i) scalars.push_back(i);
  Eigen::MatrixXd map(kScalars, kScalars);
  for (size_t unit = 0; unit < kScalars; ++unit) {
    Evaluation evaluation;
    evaluation.sigma.assign(kScalars, 0.5);
    evaluation.whitened.assign(kScalars, 0);
    evaluation.whitened[unit] = 1 / 0.5;
    evaluation.log_det = {0};
    whiten_low_rank(scalars, causes, 0, evaluation);
    for (size_t i = 0; i < kScalars; ++i)
      map(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(unit)) = evaluation.whitened[i];
  }
  const Eigen::MatrixXd s =
      causes * causes.transpose() + 0.25 * Eigen::MatrixXd::Identity(kScalars, kScalars);
  EXPECT_LT((map.transpose() * map * s - Eigen::MatrixXd::Identity(kScalars, kScalars)).norm(),
            1e-12);
}

}  // namespace
}  // namespace seam::measurement
