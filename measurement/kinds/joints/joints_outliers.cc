// Gross errors of servo logs. Right after a change of command a missing effect leaves residuals
// that stand out of their neighbours just as gross errors do; what tells them apart is that the
// former come with nearly every change of that size.
#include <algorithm>
#include <cmath>

#include "measurement/kinds/joints/joints.h"
#include "measurement/numerics/robust.h"

namespace seam::measurement {

std::vector<char> JointsProblem::find_outliers(const Model& model) const {
  std::vector<char> outlier = Problem::find_outliers(model);
  if (std::find(outlier.begin(), outlier.end(), 1) == outlier.end()) return outlier;
  constexpr size_t kMemory = 4;      // Rows for which a change of command counts as recent.
  constexpr double kOftenIs = 0.05;  // A larger share of like rows is no accident.
  const Evaluation evaluation = evaluate(model, all_groups(), nullptr);
  // By row (one scalar a row): the recent range of the command, and the distance to neighbours.
  std::vector<double> range(facts_.rows(), 0), distance(facts_.rows(), 0);
  for (const JointLog& log : set_.logs) {
    for (size_t k = 0; k < log.rows.size(); ++k) {
      const size_t row = log.rows[k];
      const size_t from = k > kMemory ? k - kMemory : 0;
      const auto [low, high] =
          std::minmax_element(log.command_rad.begin() + static_cast<std::ptrdiff_t>(from),
                              log.command_rad.begin() + static_cast<std::ptrdiff_t>(k) + 1);
      // The joint's own way from its start counts as a change of command.
      const double start = k <= kMemory ? std::abs(log.command_rad[0] - log.measured_rad[0]) : 0;
      range[row] = std::max(*high - *low, start);
      std::vector<double> around;
      for (const int other : neighbours(row, kNearRows))
        around.push_back(evaluation.residual[other]);
      distance[row] =
          std::abs(evaluation.residual[row] - (around.size() < 3 ? 0 : median_of(around)));
    }
  }
  std::vector<char> kept = outlier;
  for (size_t row = 0; row < outlier.size(); ++row) {
    if (!outlier[row] || distance[row] > 1.2 * range[row]) continue;
    size_t like = 0, deviating = 0;
    for (size_t other = 0; other < outlier.size(); ++other) {
      if (range[other] < distance[row]) continue;
      ++like;
      deviating += outlier[other] && distance[other] > 0.3 * distance[row];
    }
    if (static_cast<double>(deviating) > kOftenIs * static_cast<double>(like)) kept[row] = 0;
  }
  return kept;
}

}  // namespace seam::measurement
