#include "measurement/fitting/foretaste.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/regression.h"

namespace seam::measurement {
namespace {

// The best fit to all rows leads the fit to a few by chi-square of the parameters over two, as many
// times as all rows are more, and as errors are larger than the noise. This is what it hardly ever
// leads by: one of a million.
double lead_of_all(const Problem& problem, const FewRows& few, const Assessment& assessment) {
  constexpr double kHardlyEver = 4.75;  // Standard deviations.
  const auto k = static_cast<double>(assessment.unknowns.size());
  if (k == 0) return 0;
  const double times = static_cast<double>(count_used(problem)) / std::max(1.0, residuals_of(few));
  return 0.5 * chi2_at(kHardlyEver, k) * times * std::max(1.0, assessment.error * assessment.error);
}

}  // namespace

std::optional<FewRows> foretasters(const Problem& problem, const Model& model, double material) {
  const bool in_turn = problem.folds().size() != 1 || problem.facts().groups.size() < kFewGroups;
  if ((in_turn && !problem.beginnings()) || problem.screening_groups()) return std::nullopt;
  return enough_to_tell(problem, model, in_turn ? problem.all_groups() : problem.training_groups(),
                        material);
}

Foretaste foretaste(const Problem& problem, const FewRows& few, const Model& model,
                    const std::vector<Unknown>& unknowns) {
  Foretaste out{.assessment = assess_fitted_to(problem, *few.problem, few.groups, model, unknowns)};
  out.most_ll = out.assessment.total_ll + lead_of_all(problem, few, out.assessment);
  return out;
}

bool stays_below(const Problem& problem, const Model& model, const std::vector<Unknown>& unknowns,
                 double log_likelihood) {
  constexpr double kFewRows = 0.1;  // As many as tell of a tenth of the noise.
  const auto few = foretasters(problem, model, kFewRows);
  if (!few) return false;
  const Foretaste taste = foretaste(problem, *few, model, unknowns);
  if (!taste.assessment.valid || taste.most_ll >= log_likelihood) return false;
  // Few rows may lead a fit astray that begins where it need not move.
  const Score begins = problem.score(model, problem.all_groups());
  return !begins.valid || begins.log_likelihood < log_likelihood;
}

}  // namespace seam::measurement
