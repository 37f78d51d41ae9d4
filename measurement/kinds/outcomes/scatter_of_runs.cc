#include "measurement/kinds/outcomes/scatter_of_runs.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/config.h"

namespace seam::measurement {
namespace {

constexpr uint64_t kEnoughRuns = 32;         // They know their scatter to 12 %.
constexpr uint64_t kDrawsApart = 1'000'000;  // Far from those of measured runs.

// Whether runs of the plan can be made with other seeds (docs/sweeps.md).
bool has_seeds(const RunPlan& plan) {
  return ConfigNode::from_file(plan.file).find("seeds").has_value();
}

// Tables of equal settings as one, the runs of each setting together.
std::vector<std::vector<double>> by_setting(const std::vector<RunTable>& tables, size_t alike) {
  std::vector<std::vector<double>> all;
  for (size_t first = 0; first < tables.front().runs.size(); first += alike) {
    for (const RunTable& table : tables) {
      const size_t end = std::min(first + alike, table.runs.size());
      for (size_t i = first; i < end; ++i) all.push_back(table.runs[i]);
    }
  }
  return all;
}

}  // namespace

uint64_t further_tables(const RunSpec& spec, const RunMaker& runs, size_t plan) {
  const uint64_t there = runs.runs(plan);
  if (there >= kEnoughRuns || !has_seeds(spec.plans[plan])) return 0;
  return (kEnoughRuns + there - 1) / there - 1;
}

Scatter scatter_of(const RunSpec& spec, RunMaker& runs, size_t plan, const effects::Model& model,
                   const RunTable& first, const std::vector<ColumnStatistic>& wanted,
                   uint64_t stream) {
  const size_t alike = runs.alike(plan);
  const uint64_t further = further_tables(spec, runs, plan);
  StatisticsOfRuns of_first = statistics_of(first.runs, alike, wanted);
  Scatter scatter{.covariance = std::move(of_first.covariance),
                  .beyond = std::vector<double>(wanted.size(), 0)};
  if (further == 0) return scatter;
  std::vector<RunTable> tables = {first};
  for (uint64_t i = 1; i <= further; ++i) {
    tables.push_back(runs.make(plan, model, kDrawsApart * (stream + 1) + i));
    const auto value = statistics_of(tables.back().runs, alike, wanted).value;
    for (size_t k = 0; k < wanted.size(); ++k) {
      const double by = value[k] - of_first.value[k];
      if (std::isfinite(by)) scatter.beyond[k] += by / static_cast<double>(further + 1);
    }
  }
  scatter.tables = tables.size();
  scatter.covariance =
      covariance_of(by_setting(tables, alike), alike * tables.size(), alike, wanted);
  return scatter;
}

Eigen::MatrixXd scatter_beside(const Eigen::MatrixXd& given, const Eigen::MatrixXd& given_by_table,
                               const Eigen::MatrixXd& by_table, size_t runs) {
  constexpr double kLeast = 0.1;  // Of the variance that is known.
  const double trust = static_cast<double>(runs) / static_cast<double>(runs + kEnoughRuns);
  Eigen::MatrixXd scatter = given;
  for (Eigen::Index i = 0; i < given.rows(); ++i) {
    const double known = given(i, i);
    const double variance =
        std::max(kLeast * known, known + trust * (by_table(i, i) - given_by_table(i, i)));
    if (known > 0) {
      scatter.row(i) *= std::sqrt(variance / known);
      scatter.col(i) *= std::sqrt(variance / known);
    } else {
      scatter(i, i) = variance;
    }
  }
  return scatter;
}

}  // namespace seam::measurement
