#include "measurement/search/models/compare.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "measurement/search/candidates.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

namespace {

// Errors of fewer rows say nothing of how often they come.
constexpr long kFewLarge = 10;

bool comes_now_and_then(const EffectDefinition& effect) {
  return effect.errors == effects::Errors::now_and_then;
}

std::vector<char> rows_of(const Problem& problem, const std::vector<char>& outliers) {
  std::vector<char> rows(problem.facts().rows(), 0);
  for (size_t i = 0; i < outliers.size(); ++i) {
    if (outliers[i]) rows[problem.facts().row_of[i]] = 1;
  }
  return rows;
}

bool are_few(const std::vector<char>& rows) {
  return std::count(rows.begin(), rows.end(), 1) < kFewLarge;
}

// Whether more of these rows follow one another than by chance, in time in their series or among
// rows of one label: a burst has one cause, and comes but once.
bool come_in_bursts(const Facts& facts, const std::vector<char>& rows) {
  const auto follow = [&](const auto& label_of) {
    std::vector<size_t> order(rows.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
      return std::pair(label_of(a), facts.time_of_row[a]) <
             std::pair(label_of(b), facts.time_of_row[b]);
    });
    double pairs = 0;
    for (size_t k = 1; k < order.size(); ++k)
      pairs += rows[order[k - 1]] && rows[order[k]] && label_of(order[k - 1]) == label_of(order[k]);
    const auto n = static_cast<double>(std::count(rows.begin(), rows.end(), 1));
    const double by_chance = n * n / static_cast<double>(rows.size());
    return pairs > by_chance + 3 * std::sqrt(by_chance) + 1;
  };
  if (follow([&](size_t row) {
        return facts.series_of_row.empty() ? facts.group_of_row[row] : facts.series_of_row[row];
      }))
    return true;
  return std::any_of(
      facts.covariates.begin(), facts.covariates.end(), [&](const Covariate& covariate) {
        return covariate.type == Covariate::Type::category &&
               covariate.values.size() == rows.size() && follow([&](size_t row) {
                 return std::isnan(covariate.values[row]) ? -1 : covariate.values[row];
               });
      });
}

// The model with an effect that makes large errors now and then, where one explains nearly all that
// were left out; else the model.
Model with_large_errors(Problem& problem, const Grown& best) {
  const std::vector<char> marked = problem.left_out();
  const std::vector<char> rows = rows_of(problem, marked);
  if (marked.empty() || are_few(rows) || come_in_bursts(problem.facts(), rows))
    return best.assessment.model;
  EffectList effects = absent_effects(problem, best.assessment.model, {});
  std::erase_if(effects, [](const auto& effect) { return !comes_now_and_then(*effect); });
  Model found = best.assessment.model;
  problem.leave_out({});
  for (const auto& effect : effects) {
    std::vector<NotTestable> reasons;
    const auto candidate = try_effect(problem, best, effect, reasons);
    if (!candidate) continue;
    const Model& model = candidate->grown.assessment.model;
    if (are_few(rows_of(problem, problem.find_outliers(model)))) {
      found = model;
      break;
    }
  }
  problem.leave_out(marked);
  return found;
}

// What is left out for being large is what the size of large errors is estimated from.
Model fitted_to_all_rows(Problem& problem, const Grown& best) {
  const std::vector<char> marked = problem.left_out();
  problem.leave_out({});
  const Assessment all = assess(problem, best.assessment.model, best.assessment.unknowns);
  problem.leave_out(marked);
  return all.valid ? all.model : best.assessment.model;
}

// Without what was added of them.
Model without_large_errors(const Model& given, const Model& model) {
  Model without = model;
  for (const effects::ModelEffect& effect : model.effects()) {
    const std::string& name = effect.definition->name;
    if (comes_now_and_then(*effect.definition) && given.find(name) == nullptr) without.remove(name);
  }
  return without;
}

}  // namespace

bool estimates_large_errors(const Model& given, const Model& model) {
  return without_large_errors(given, model).effects().size() < model.effects().size();
}

Model judge_of_outliers(Problem& problem, const Model& given, const Grown& best,
                        LargeErrors large_errors) {
  const Model& model = best.assessment.model;
  const bool estimates = estimates_large_errors(given, model);
  if (estimates && large_errors == LargeErrors::proven) return fitted_to_all_rows(problem, best);
  if (large_errors == LargeErrors::in_vain) return model;
  if (!estimates) return with_large_errors(problem, best);
  const Model without = without_large_errors(given, model);
  return are_few(rows_of(problem, problem.find_outliers(without))) ? without : model;
}

double error_beside_outliers(const Problem& problem, const Model& model) {
  const Evaluation here = problem.evaluate(model, problem.all_groups());
  const std::vector<char> outlier = problem.find_outliers(model);
  double all = 0, count = 0, of_others = 0, others = 0;
  for (size_t i = 0; i < std::min(here.used.size(), here.whitened.size()); ++i) {
    if (!here.used[i]) continue;
    const double square = here.whitened[i] * here.whitened[i];
    all += square, ++count;
    if (i < outlier.size() && outlier[i]) continue;
    of_others += square, ++others;
  }
  if (!(count > 0)) return 0;
  const bool few = others >= (1 - kMostOutliers) * count;
  return few ? std::sqrt(of_others / others) : std::sqrt(all / count);
}

bool mark_outliers(Problem& problem, const Model& model, SearchResult& result, bool keep) {
  std::vector<char> outliers = problem.find_outliers(model);
  if (keep && problem.left_out().size() == outliers.size()) {
    for (size_t i = 0; i < outliers.size(); ++i) outliers[i] |= problem.left_out()[i];
  }
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
