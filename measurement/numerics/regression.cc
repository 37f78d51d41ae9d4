#include "measurement/numerics/regression.h"

#include <Eigen/Core>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

double clamped(double p) {
  return std::clamp(std::isfinite(p) ? p : 1.0, 1e-300, 1.0);
}

// Sum of squares of y that the first `count` columns explain, from their Gram matrix; rank found
// by eigenvalues of the scaled matrix.
double explained_by(const Eigen::MatrixXd& gram, const Eigen::VectorXd& moments, Eigen::Index count,
                    int& rank) {
  rank = 0;
  if (count == 0) return 0;
  const Eigen::VectorXd scale =
      gram.diagonal().head(count).cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd scaled =
      scale.asDiagonal() * gram.topLeftCorner(count, count) * scale.asDiagonal();
  const SymmetricEigen eigen = symmetric_eigen(scaled);
  const Eigen::VectorXd along =
      eigen.vectors.transpose() * (scale.asDiagonal() * moments.head(count));
  double sum = 0;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (eigen.values[i] < 1e-9) continue;
    sum += along[i] * along[i] / eigen.values[i];
    ++rank;
  }
  return sum;
}

NestedTest finish(double total, double explained_null, double explained_all, int rank_null,
                  int rank_all, double n, double lost) {
  NestedTest test{.extra = rank_all - rank_null};
  const double freedom = n - rank_all - lost;
  if (test.extra <= 0 || freedom < 3) return test;
  test.explained = std::max(0.0, explained_all - explained_null);
  const double rest = std::max(total - explained_all, 1e-12 * total);
  if (!(rest > 0)) return test;
  const double variance = rest / freedom;
  test.p_value = f_tail(test.explained / test.extra / variance, test.extra, freedom);
  test.rms = std::sqrt(std::max(0.0, test.explained - test.extra * variance) / n);
  return test;
}

}  // namespace

NestedTest nested_test(const std::vector<double>& y,
                       const std::vector<std::vector<double>>& null_columns,
                       const std::vector<std::vector<double>>& extra_columns, double lost) {
  const Eigen::Index n = static_cast<Eigen::Index>(y.size());
  const Eigen::Index nulls = static_cast<Eigen::Index>(null_columns.size());
  const Eigen::Index all = nulls + static_cast<Eigen::Index>(extra_columns.size());
  if (n <= all + 3) return {};
  Eigen::MatrixXd A(n, all);
  for (Eigen::Index c = 0; c < all; ++c) {
    const auto& column = c < nulls ? null_columns[c] : extra_columns[c - nulls];
    A.col(c) = Eigen::Map<const Eigen::VectorXd>(column.data(), n);
  }
  const Eigen::Map<const Eigen::VectorXd> target(y.data(), n);
  const Eigen::MatrixXd gram = A.transpose() * A;
  const Eigen::VectorXd moments = A.transpose() * target;
  int rank_null = 0, rank_all = 0;
  const double explained_null = explained_by(gram, moments, nulls, rank_null);
  const double explained_all = explained_by(gram, moments, all, rank_all);
  return finish(target.squaredNorm(), explained_null, explained_all, rank_null, rank_all,
                static_cast<double>(n), lost);
}

NestedTest category_test(const std::vector<double>& y, const std::vector<int>& label, double lost) {
  if (y.empty()) return {};
  const int levels = *std::max_element(label.begin(), label.end()) + 1;
  std::vector<double> sum(levels, 0), count(levels, 0);
  double total = 0, all = 0;
  for (size_t i = 0; i < y.size(); ++i) {
    sum[label[i]] += y[i];
    count[label[i]] += 1;
    total += y[i] * y[i];
    all += y[i];
  }
  double explained = 0;
  int used = 0;
  for (int l = 0; l < levels; ++l) {
    if (count[l] == 0) continue;
    explained += sum[l] * sum[l] / count[l];
    ++used;
  }
  const double n = static_cast<double>(y.size());
  return finish(total, all * all / n, explained, 1, used, n, lost);
}

double f_tail(double f, double numerator, double denominator) {
  if (!(f > 0)) return 1;
  if (std::isinf(f)) return 1e-300;  // Boost takes no infinity.
  const boost::math::fisher_f distribution(numerator, denominator);
  return clamped(boost::math::cdf(boost::math::complement(distribution, f)));
}

double chi2_tail(double x, double freedom) {
  if (!(x > 0)) return 1;
  if (x > 1400 + 2 * freedom) return 1e-300;  // Below the least double; boost would say so.
  return clamped(boost::math::cdf(boost::math::complement(boost::math::chi_squared(freedom), x)));
}

double chi2_at(double sigmas, double freedom) {
  const double part = 2 / (9 * freedom), root = 1 - part + sigmas * std::sqrt(part);
  return freedom * root * root * root;
}

double corrected(double p, double looks) {
  return p <= 1e-297 ? 1e-300 : std::min(1.0, p * looks);
}

double normal_tail(double z) {
  return clamped(std::erfc(std::abs(z) / std::sqrt(2.0)));
}

std::vector<double> normal_scores(const std::vector<double>& values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return values[a] < values[b]; });
  std::vector<double> scores(values.size());
  const boost::math::normal standard;
  for (size_t rank = 0; rank < order.size(); ++rank) {
    scores[order[rank]] = boost::math::quantile(
        standard, (static_cast<double>(rank) + 0.5) / static_cast<double>(values.size()));
  }
  return scores;
}

}  // namespace seam::measurement
