// Gross errors: residuals far from those of their neighbours (docs/definitions.md, "Outlier").
#include <algorithm>
#include <cmath>
#include <numeric>

#include "measurement/numerics/robust.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

std::vector<int> Problem::neighbours(size_t row) const {
  const auto series = [&](int r) {
    return facts_.series_of_row.empty() ? facts_.group_of_row[r] : facts_.series_of_row[r];
  };
  if (series_order_.size() != facts_.rows()) {
    series_order_.resize(facts_.rows());
    std::iota(series_order_.begin(), series_order_.end(), 0);
    std::stable_sort(series_order_.begin(), series_order_.end(), [&](int a, int b) {
      return std::pair(series(a), facts_.time_of_row[a]) <
             std::pair(series(b), facts_.time_of_row[b]);
    });
    series_place_.resize(facts_.rows());
    for (size_t i = 0; i < series_order_.size(); ++i)
      series_place_[series_order_[i]] = static_cast<int>(i);
  }
  constexpr int kReach = 4;
  std::vector<int> near;
  const int place = series_place_[row];
  const int count = static_cast<int>(facts_.rows());
  for (int step = 1; step <= 2 * kReach && near.size() < 2 * kReach; ++step) {
    for (const int there : {place - step, place + step}) {
      if (there < 0 || there >= count) continue;
      if (series(series_order_[there]) == series(static_cast<int>(row)))
        near.push_back(series_order_[there]);
    }
  }
  return near;
}

std::vector<char> Problem::find_outliers(const Model& model) const {
  constexpr double kSigmas = 6;
  const Evaluation evaluation = evaluate(model, all_groups());
  const size_t n = facts_.scalars();
  std::vector<char> outlier(n, 0);
  std::vector<double> deviation(n, 0);
  std::vector<std::vector<size_t>> scalars_of_row(facts_.rows());
  for (size_t i = 0; i < n; ++i) scalars_of_row[facts_.row_of[i]].push_back(i);
  std::vector<std::vector<double>> by_channel(facts_.channels.size());
  for (size_t row = 0; row < facts_.rows(); ++row) {
    if (scalars_of_row[row].empty()) continue;
    const std::vector<int> near = neighbours(row);
    for (const size_t i : scalars_of_row[row]) {
      std::vector<double> around;
      for (const int other : near) {
        for (const size_t k : scalars_of_row[other]) {
          if (facts_.channel_of[k] == facts_.channel_of[i])
            around.push_back(evaluation.residual[k]);
        }
      }
      const double middle = around.size() < 3 ? 0 : median_of(around);
      deviation[i] = (evaluation.residual[i] - middle) / evaluation.sigma[i];
      // Where the model has a few large errors, it says itself which it does not expect.
      if (!evaluation.deviance.empty())
        deviation[i] = std::min(std::abs(deviation[i]), evaluation.deviance[i]);
      by_channel[facts_.channel_of[i]].push_back(deviation[i]);
    }
  }
  std::vector<double> limit;
  for (const auto& values : by_channel)
    limit.push_back(kSigmas * std::max(1.0, robust_sigma(values)));
  std::vector<char> bad_row(facts_.rows(), 0);
  for (size_t i = 0; i < n; ++i) {
    if (std::abs(deviation[i]) > limit[facts_.channel_of[i]]) bad_row[facts_.row_of[i]] = 1;
  }
  for (size_t i = 0; i < n; ++i) outlier[i] = bad_row[facts_.row_of[i]];
  return outlier;
}

}  // namespace seam::measurement
