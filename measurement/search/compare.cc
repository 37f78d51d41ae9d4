#include "measurement/search/compare.h"

#include <algorithm>

#include "sim_core/base/error.h"

namespace seam::measurement {

Model judge_of_outliers(const Problem& problem, const Model& given, const Model& best) {
  constexpr long kFewLarge = 10;
  Model without = best;
  for (const effects::ModelEffect& effect : best.effects()) {
    const std::string& name = effect.definition->name;
    if (effect.definition->errors == effects::Errors::now_and_then && given.find(name) == nullptr)
      without.remove(name);
  }
  if (without.effects().size() == best.effects().size()) return best;
  const std::vector<char> outliers = problem.find_outliers(without);
  std::vector<char> rows(problem.facts().rows(), 0);
  for (size_t i = 0; i < outliers.size(); ++i) {
    if (outliers[i]) rows[problem.facts().row_of[i]] = 1;
  }
  return std::count(rows.begin(), rows.end(), 1) < kFewLarge ? without : best;
}

bool mark_outliers(Problem& problem, const Model& model, SearchResult& result) {
  std::vector<char> outliers = problem.find_outliers(model);
  const size_t count = static_cast<size_t>(std::count(outliers.begin(), outliers.end(), 1));
  result.outlier_share =
      static_cast<double>(count) / static_cast<double>(std::max<size_t>(1, outliers.size()));
  result.outliers.clear();
  if (result.outlier_share > kMostOutliers || count == 0) outliers.clear();
  const bool changed = outliers != problem.left_out();
  problem.leave_out(std::move(outliers));
  if (count == 0 || result.outlier_share > kMostOutliers) return changed;
  const Evaluation evaluation = problem.evaluate(model, problem.all_groups());
  for (size_t i = 0; i < problem.left_out().size(); ++i) {
    if (!problem.left_out()[i]) continue;
    const int row = problem.facts().row_of[i];
    result.outliers.push_back({.line = problem.facts().line_of_row[row],
                               .scalar = i,
                               .residual = evaluation.residual[i]});
  }
  return changed;
}

CompareResult compare(Problem& problem, const Model& model, double material) {
  problem.check_model(model);
  problem.prepare(model);
  CompareResult result;
  SearchResult marks;
  problem.leave_out({});
  Assessment assessment = assess(problem, model, refitted_unknowns(model));
  check_enough(problem, assessment);
  for (int round = 0; round < kOutlierRounds && mark_outliers(problem, assessment.model, marks);
       ++round) {
    assessment = assess(problem, model, refitted_unknowns(model));
  }
  result.outliers = marks.outliers;
  result.outlier_share = marks.outlier_share;
  result.base.assessment = std::move(assessment);
  SplitStructure found = significant_structure(problem, result.base.assessment, material);
  result.structure = std::move(found.material);
  result.traces = std::move(found.traces);
  result.material = material;
  return result;
}

}  // namespace seam::measurement
