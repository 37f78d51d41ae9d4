// Gross errors: residuals far from those of their neighbours (docs/reference/definitions.md,
// "Outlier").
#include <algorithm>
#include <cmath>
#include <numeric>

#include "measurement/numerics/robust.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

std::vector<int> Problem::neighbours(size_t row, size_t count) const {
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
  std::vector<int> near;
  const int place = series_place_[row];
  const int last = static_cast<int>(facts_.rows());
  const int reach = static_cast<int>(count);
  for (int step = 1; step <= reach && near.size() < count; ++step) {
    for (const int there : {place - step, place + step}) {
      if (there < 0 || there >= last || near.size() >= count) continue;
      if (series(series_order_[there]) == series(static_cast<int>(row)))
        near.push_back(series_order_[there]);
    }
  }
  return near;
}

namespace {

constexpr size_t kWide = 24;
constexpr double kSigmas = 6;

// The distance of each residual from the middle of those around it, in its sigmas.
class Deviations {
 public:
  Deviations(const Problem& problem, const Evaluation& evaluation)
      : problem_(problem), evaluation_(evaluation), scalars_of_row_(problem.facts().rows()) {
    for (size_t i = 0; i < problem.facts().scalars(); ++i)
      scalars_of_row_[problem.facts().row_of[i]].push_back(i);
  }

  // Those from a few neighbours; then, where some of these are far from their middle, from many.
  std::vector<double> all() {
    deviation_.assign(problem_.facts().scalars(), 0);
    for (size_t row = 0; row < scalars_of_row_.size(); ++row) judge(row, /*wide=*/false);
    limit_ = limits();
    for (size_t row = 0; row < scalars_of_row_.size(); ++row) judge(row, /*wide=*/true);
    return deviation_;
  }

  // By channel.
  std::vector<double> limits() const {
    std::vector<std::vector<double>> by_channel(problem_.facts().channels.size());
    for (const auto& scalars : scalars_of_row_) {
      for (const size_t i : scalars)
        by_channel[problem_.facts().channel_of[i]].push_back(deviation_[i]);
    }
    std::vector<double> limits;
    for (auto& values : by_channel)
      limits.push_back(kSigmas * std::max(1.0, robust_sigma(std::move(values))));
    return limits;
  }

 private:
  double limit_of(size_t scalar) const { return limit_[problem_.facts().channel_of[scalar]]; }

  std::vector<double> around(size_t scalar, const std::vector<int>& rows) const {
    const auto& channel_of = problem_.facts().channel_of;
    std::vector<double> residuals;
    for (const int row : rows) {
      for (const size_t k : scalars_of_row_[row]) {
        if (channel_of[k] == channel_of[scalar]) residuals.push_back(evaluation_.residual[k]);
      }
    }
    return residuals;
  }

  static double middle_of(const std::vector<double>& residuals) {
    return residuals.size() < 3 ? 0 : median_of(residuals);
  }

  void set(size_t scalar, double middle) {
    double& deviation = deviation_[scalar];
    deviation = (evaluation_.residual[scalar] - middle) / evaluation_.sigma[scalar];
    // Where the model has a few large errors, it says itself which it does not expect.
    if (!evaluation_.deviance.empty())
      deviation = std::min(std::abs(deviation), evaluation_.deviance[scalar]);
  }

  void judge(size_t row, bool wide) {
    if (scalars_of_row_[row].empty()) return;
    const std::vector<int> few = problem_.neighbours(row, kNearRows);
    std::vector<int> many;
    for (const size_t i : scalars_of_row_[row]) {
      const std::vector<double> near = around(i, few);
      if (!wide) {
        set(i, middle_of(near));
      } else if (any_far(i, near)) {
        if (many.empty()) many = problem_.neighbours(row, kWide);
        const std::vector<double> far = around(i, many);
        if (is_calm(i, far)) set(i, middle_of(far));
      }
    }
  }

  bool any_far(size_t scalar, const std::vector<double>& near) const {
    const double middle = middle_of(near), far = limit_of(scalar) * evaluation_.sigma[scalar];
    return std::any_of(near.begin(), near.end(),
                       [&](double residual) { return std::abs(residual - middle) > far; });
  }

  // Whether most of them lie about their middle as noise does: nothing but single errors or bursts
  // of them stands out there, however many of the nearest do.
  bool is_calm(size_t scalar, std::vector<double> residuals) const {
    constexpr double kCalm = 2;  // Of the noise: where residuals drift, the nearest say more.
    if (residuals.size() < kWide / 2) return false;
    const double middle = middle_of(residuals);
    for (double& residual : residuals) residual -= middle;
    return robust_sigma(std::move(residuals)) <
           kCalm / kSigmas * limit_of(scalar) * evaluation_.sigma[scalar];
  }

  const Problem& problem_;
  const Evaluation& evaluation_;
  std::vector<std::vector<size_t>> scalars_of_row_;
  std::vector<double> deviation_, limit_;
};

}  // namespace

std::vector<char> Problem::find_outliers(const Model& model) const {
  const Evaluation evaluation = evaluate(model, all_groups());
  Deviations deviations(*this, evaluation);
  const std::vector<double> deviation = deviations.all();
  const std::vector<double> limit = deviations.limits();
  std::vector<char> bad_row(facts_.rows(), 0);
  for (size_t i = 0; i < deviation.size(); ++i) {
    if (std::abs(deviation[i]) > limit[facts_.channel_of[i]]) bad_row[facts_.row_of[i]] = 1;
  }
  std::vector<char> outlier(deviation.size(), 0);
  for (size_t i = 0; i < outlier.size(); ++i) outlier[i] = bad_row[facts_.row_of[i]];
  return outlier;
}

}  // namespace seam::measurement
