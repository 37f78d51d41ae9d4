// Tests of structure against orthogonal projections, printed tables and a textbook's numbers.
#include "measurement/numerics/regression.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

using Columns = std::vector<std::vector<double>>;

Eigen::MatrixXd as_matrix(const Columns& columns, size_t rows) {
  Eigen::MatrixXd out(rows, columns.size());
  for (size_t c = 0; c < columns.size(); ++c) {
    for (size_t i = 0; i < rows; ++i)
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) = columns[c][i];
  }
  return out;
}

double rest_of(const Columns& columns, const std::vector<double>& y) {
  const Eigen::MatrixXd a = as_matrix(columns, y.size());
  const Eigen::Map<const Eigen::VectorXd> target(y.data(), static_cast<Eigen::Index>(y.size()));
  const Eigen::VectorXd x = a.colPivHouseholderQr().solve(Eigen::VectorXd(target));
  return (target - a * x).squaredNorm();
}

TEST(Regression, NestedTestIsTheFTestOfTwoProjections) {
  constexpr size_t kRows = 60;
  const RandomStream stream{.seed = 8};
  Columns null_columns(2, std::vector<double>(kRows)), extra(3, std::vector<double>(kRows));
  std::vector<double> y(kRows);
  for (size_t i = 0; i < kRows; ++i) {
    const double x = static_cast<double>(i) / kRows;
    null_columns[0][i] = 1, null_columns[1][i] = x;
    extra[0][i] = 1e6 * x * x, extra[1][i] = 1e-6 * std::sin(9 * x), extra[2][i] = std::exp(x);
    y[i] = 3 - x + 0.8 * std::sin(9 * x) + normal(stream, i);
  }
  Columns all = null_columns;
  all.insert(all.end(), extra.begin(), extra.end());
  const double without = rest_of(null_columns, y), with = rest_of(all, y);
  constexpr double kLost = 4, kFreedom = kRows - 5 - kLost;
  const double f = (without - with) / 3 / (with / kFreedom);
  const boost::math::fisher_f distribution(3, kFreedom);

  const NestedTest test = nested_test(y, null_columns, extra, kLost);
  EXPECT_EQ(test.extra, 3);
  EXPECT_NEAR(test.explained, without - with, 1e-8 * without);
  EXPECT_NEAR(test.p_value / boost::math::cdf(complement(distribution, f)), 1, 1e-6);
  EXPECT_NEAR(test.rms, std::sqrt((without - with - 3 * with / kFreedom) / kRows), 1e-7);
}

TEST(Regression, AColumnThatIsThereAlreadyAddsNothing) {
  constexpr size_t kRows = 40;
  const RandomStream stream{.seed = 9};
  Columns null_columns(2, std::vector<double>(kRows)), extra(2, std::vector<double>(kRows));
  std::vector<double> y(kRows);
  for (size_t i = 0; i < kRows; ++i) {
    null_columns[0][i] = 1, null_columns[1][i] = static_cast<double>(i);
    extra[0][i] = 7 - 2.0 * static_cast<double>(i);
    extra[1][i] = std::cos(static_cast<double>(i));
    y[i] = normal(stream, i);
  }
  EXPECT_EQ(nested_test(y, null_columns, extra, 0).extra, 1);
  extra.pop_back();
  const NestedTest none = nested_test(y, null_columns, extra, 0);
  EXPECT_EQ(none.extra, 0);
  EXPECT_EQ(none.p_value, 1);
}

// Under the null hypothesis p-values are uniform: 2,000 of them, largest distance of the cumulated
// share from the diagonal below what chance exceeds once in a thousand (Kolmogorov: 1.95 / sqrt n).
TEST(Regression, PValuesOfNoiseAreUniform) {
  constexpr size_t kSets = 2000, kRows = 25;
  const RandomStream stream{.seed = 10};
  Columns null_columns(1, std::vector<double>(kRows, 1)), extra(2, std::vector<double>(kRows));
  for (size_t i = 0; i < kRows; ++i)
    extra[0][i] = static_cast<double>(i), extra[1][i] = std::sin(static_cast<double>(i));
  std::vector<int> label(kRows);
  for (size_t i = 0; i < kRows; ++i) label[i] = static_cast<int>(i % 4);
  std::vector<double> p_nested, p_category;
  for (size_t set = 0; set < kSets; ++set) {
    std::vector<double> y(kRows);
    for (size_t i = 0; i < kRows; ++i) y[i] = normal(stream, set * kRows + i);
    p_nested.push_back(nested_test(y, null_columns, extra, 0).p_value);
    p_category.push_back(category_test(y, label, 0).p_value);
  }
  for (auto* p : {&p_nested, &p_category}) {
    std::sort(p->begin(), p->end());
    double farthest = 0;
    for (size_t i = 0; i < kSets; ++i)
      farthest = std::max(farthest, std::abs((*p)[i] - (static_cast<double>(i) + 0.5) / kSets));
    EXPECT_LT(farthest, 1.95 / std::sqrt(static_cast<double>(kSets)));
  }
}

// Three groups of six: means 5, 9, 10; between 84, within 68; F = 42 / 4.5333 = 9.265 with 2 and 15
// degrees of freedom, p = 0.0024.
TEST(Regression, CategoriesAreTheAnalysisOfVariance) {
  const std::vector<double> y = {6, 8, 4, 5, 3, 4, 8, 12, 9, 11, 6, 8, 13, 9, 11, 8, 7, 12};
  std::vector<int> label;
  for (int i = 0; i < 18; ++i) label.push_back(i / 6);
  const NestedTest test = category_test(y, label, 0);
  EXPECT_EQ(test.extra, 2);
  EXPECT_NEAR(test.explained, 84, 1e-9);
  EXPECT_NEAR(test.p_value, 0.0024, 5e-5);
}

TEST(Regression, TailsAreThoseOfPrintedTables) {
  // Abramowitz and Stegun (1964), tables 26.8 and 26.9 and 26.1.
  EXPECT_NEAR(chi2_tail(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi2_tail(18.3070, 10), 0.05, 1e-6);
  EXPECT_NEAR(chi2_tail(29.5883, 10), 0.001, 1e-7);
  EXPECT_NEAR(f_tail(3.33, 5, 10), 0.05, 2e-4);
  EXPECT_NEAR(normal_tail(1.959964), 0.05, 1e-7);
  EXPECT_NEAR(normal_tail(-2.575829), 0.01, 1e-8);
  for (const double freedom : {1.0, 2.5, 7.0, 400.0}) {
    for (const double p : {0.7, 0.3, 1e-3, 1e-12, 1e-100}) {
      const double x = boost::math::quantile(complement(boost::math::chi_squared(freedom), p));
      EXPECT_NEAR(chi2_tail(x, freedom) / p, 1, 1e-9) << freedom << " " << p;
    }
  }
  EXPECT_EQ(chi2_tail(0, 3), 1);
  EXPECT_EQ(chi2_tail(1e9, 3), 1e-300);
  EXPECT_EQ(f_tail(0, 3, 10), 1);
  EXPECT_EQ(f_tail(std::numeric_limits<double>::infinity(), 3, 10), 1e-300);
}

TEST(Regression, NormalScoresAreQuantilesOfTheRanks) {
  const std::vector<double> scores = normal_scores({30, -1e9, 7, 8});
  const boost::math::normal standard;
  EXPECT_DOUBLE_EQ(scores[1], quantile(standard, 0.125));
  EXPECT_DOUBLE_EQ(scores[2], quantile(standard, 0.375));
  EXPECT_DOUBLE_EQ(scores[3], quantile(standard, 0.625));
  EXPECT_DOUBLE_EQ(scores[0], quantile(standard, 0.875));
}

}  // namespace
}  // namespace seam::measurement
