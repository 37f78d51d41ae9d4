#include "measurement/noise/driven_errors.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace seam::measurement {
namespace {

// What a state of (q, w) at the row `from` makes of the rows from there on.
Eigen::VectorXd followed(const std::vector<DrivenStep>& steps, size_t from, double q, double w) {
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(steps.size() + 1));
  for (size_t k = from; k <= steps.size(); ++k) {
    errors[static_cast<Eigen::Index>(k)] = q;
    if (k == steps.size()) break;
    const double moved = steps[k].q_of_q * q + steps[k].q_of_w * w;
    w = steps[k].w_of_q * q + steps[k].w_of_w * w, q = moved;
  }
  return errors;
}

// Against the covariance of all residuals at once.
TEST(DrivenErrors, AreWhitenedAsByTheWholeCovariance) {
  constexpr int kRows = 30;
  constexpr double kDraw = 0.7, kWander = 0.4, kTau_s = 0.2;
  Facts facts;
  facts.groups = {"a"};
  Evaluation evaluation;
  std::vector<size_t> scalars;
  std::vector<double> time_s;
  std::vector<DrivenStep> steps;
  for (int k = 0; k < kRows; ++k) {
    facts.row_of.push_back(k), facts.group_of_row.push_back(0);
    scalars.push_back(static_cast<size_t>(k));
    time_s.push_back(0.05 * k + 0.01 * std::sin(k));
    evaluation.residual.push_back(std::sin(7.0 * k * k));
    evaluation.sigma.push_back(0.3 + 0.1 * std::cos(k));
    evaluation.used.push_back(k % 7 != 3);
    if (k + 1 < kRows)
      steps.push_back({0.9, 0.04 + 0.01 * std::cos(k), -0.5, 0.7, std::sin(2.0 * k),
                       3 * std::cos(k), 0.3 * std::cos(3.0 * k), 0.4});
  }
  evaluation.whitened.assign(kRows, 0);
  evaluation.log_det = {0};
  // Errors of all rows by the draws.
  Eigen::MatrixXd by_draw = Eigen::MatrixXd::Zero(kRows, kRows - 1), by_square = by_draw;
  for (int d = 0; d + 1 < kRows; ++d) {
    by_draw.col(d) = followed(steps, d + 1, steps[d].q_of_draw, steps[d].w_of_draw);
    by_square.col(d) = followed(steps, d + 1, steps[d].q_of_square, steps[d].w_of_square);
  }
  const Eigen::VectorXd by_start = followed(steps, 0, 1, 0);
  constexpr DrivenStart kStart{.q = 0.8, .variance = 0.6};
  constexpr double kVariance = kDraw * kDraw;
  // The square of a normal draw has this mean, and twice the variance squared.
  Eigen::MatrixXd whole = kVariance * by_draw * by_draw.transpose() +
                          2 * kVariance * kVariance * by_square * by_square.transpose();
  const Eigen::VectorXd mean = kVariance * by_square.rowwise().sum() + kStart.q * by_start;
  std::vector<int> used;
  for (int a = 0; a < kRows; ++a) {
    if (evaluation.used[a]) used.push_back(a);
    for (int b = 0; b < kRows; ++b)
      whole(a, b) += kWander * kWander * std::exp(-std::abs(time_s[a] - time_s[b]) / kTau_s);
    whole(a, a) += evaluation.sigma[a] * evaluation.sigma[a];
  }
  const auto count = static_cast<Eigen::Index>(used.size());
  Eigen::MatrixXd part(count, count);
  Eigen::VectorXd residual(count);
  double own_log_det = 0;
  for (Eigen::Index a = 0; a < count; ++a) {
    residual[a] = evaluation.residual[used[a]] - mean[used[a]];
    own_log_det += 2 * std::log(evaluation.sigma[used[a]]);
    for (Eigen::Index b = 0; b < count; ++b)
      part(a, b) =
          whole(used[a], used[b]) + kStart.variance * by_start(used[a]) * by_start(used[b]);
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(part);
  const Eigen::VectorXd whitened = factor.matrixL().solve(residual);
  double log_det = 0;
  for (Eigen::Index a = 0; a < count; ++a) log_det += 2 * std::log(factor.matrixL()(a, a));

  whiten_driven(facts, scalars, time_s, steps, kStart, kDraw, {{kWander, kTau_s}}, evaluation);
  for (Eigen::Index a = 0; a < count; ++a) {
    EXPECT_NEAR(evaluation.whitened[used[a]], whitened[a], 1e-9);
    EXPECT_NEAR(evaluation.sigma[used[a]], std::sqrt(whole(used[a], used[a])), 1e-9);
  }
  EXPECT_NEAR(evaluation.log_det[0] + own_log_det, log_det, 1e-9);
}

}  // namespace
}  // namespace seam::measurement
