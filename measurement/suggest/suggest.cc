#include "measurement/suggest/suggest.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "measurement/suggest/proposer.h"

namespace seam::measurement {
namespace {

// Further columns that vary: what stays within a fiftieth of its size in most rows can stand for
// anything that is constant, and a formula of it says nothing.
std::vector<std::string> varying_columns(const Problem& problem) {
  constexpr double kHardly = 0.02;
  std::vector<std::string> names = problem.formula_columns();
  std::erase_if(names, [&](const std::string& name) {
    for (const Covariate& covariate : problem.facts().covariates) {
      if (covariate.name != name || covariate.values.empty()) continue;
      std::vector<double> sorted = covariate.values;
      std::erase_if(sorted, [](double x) { return !std::isfinite(x); });
      if (sorted.empty()) return true;
      std::sort(sorted.begin(), sorted.end());
      const auto at = [&](double share) {
        return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
      };
      return at(0.9) - at(0.1) <= kHardly * std::max(std::abs(at(0.9)), std::abs(at(0.1)));
    }
    return false;
  });
  return names;
}

}  // namespace

std::optional<Suggestion> suggest(const Problem& problem, const Grown& beside) {
  const effects::Kind kind = problem.facts().set.kind;
  if (kind == effects::Kind{}) return std::nullopt;  // A set made for tests.
  const auto stages = vocabularies(kind, beside.assessment.model, varying_columns(problem));
  std::optional<Formula> best;
  for (const Vocabulary& vocabulary : stages) {
    auto formula = formula_of(problem, beside.assessment, vocabulary);
    if (formula && (!best || formula->merit > best->merit)) best = std::move(formula);
  }
  if (!best) return std::nullopt;
  Suggestion suggestion{.effect = best->assessment.unknowns.back().effect,
                        .formula = formula_text(best->terms),
                        .beside = beside.added,
                        .error_before = beside.assessment.error,
                        .error = best->assessment.error,
                        .log_evidence = best->log_evidence};
  const Fit& fit = best->assessment.fit;
  const auto& parameters = best->assessment.model.find(suggestion.effect)->definition->parameters;
  for (size_t i = 0, k = fit.value.size() - parameters.size(); i < parameters.size(); ++i, ++k)
    suggestion.numbers.push_back({parameters[i].name, fit.value[k], fit.sigma[k]});
  for (const Term& term : best->terms) suggestion.terms.push_back(term.label());
  const std::string help = fmt::format(
      "Proposed from residuals: error {:.4g} -> {:.4g} on held-out groups{}.",
      suggestion.error_before, suggestion.error,
      beside.added.empty() ? "" : fmt::format(" beside {}", fmt::join(beside.added, ", ")));
  suggestion.yaml = formula_yaml(suggestion.effect, best->vocabulary->stage, help, best->terms);
  return suggestion;
}

}  // namespace seam::measurement
