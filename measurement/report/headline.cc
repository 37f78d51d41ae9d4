#include "measurement/report/headline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace seam::measurement {
namespace {

// The structure that is strongest in noise units.
std::string strongest_text(const Problem& problem, const Assessment& assessment,
                           const std::vector<Structure>& structure) {
  const auto units = [&](const Structure& s) { return noise_units(problem, assessment, s); };
  const Structure& most = *std::max_element(
      structure.begin(), structure.end(),
      [&](const Structure& a, const Structure& b) { return units(a) < units(b); });
  return fmt::format("the {} of {} depends on {}, by {:.2g} noise units", most.moment,
                     most.residual, most.covariate, units(most));
}

// What a fit to all groups leaves of the noise; infinite where the fit was to training groups.
double error_of_all(const Problem& problem, const Assessment& assessment) {
  if (problem.folds().size() < 2) return std::numeric_limits<double>::infinity();
  const Score all = problem.score(assessment.model, problem.all_groups());
  const double freedom =
      static_cast<double>(all.n - all.nuisances) - static_cast<double>(assessment.unknowns.size());
  return all.valid && freedom > 0 ? std::sqrt(all.chi2 / freedom)
                                  : std::numeric_limits<double>::infinity();
}

std::string nothing_text(const Problem& problem, const Assessment& assessment, double material,
                         size_t traces) {
  const double of_all =
      assessment.error > kMisfit ? error_of_all(problem, assessment) : assessment.error;
  // A group that is held out may be met by no values that the others leave open.
  if (assessment.error > kMisfit && of_all < kMisfit)
    return fmt::format(
        "What matters: more groups; all {} together are met to {:.3g} times the noise, but each of "
        "them is needed to tell the model's values: held out, it is missed by {:.3g} times\n",
        problem.facts().groups.size(), of_all, assessment.error);
  if (assessment.error > kMisfit)
    return fmt::format(
        "What matters: the error is {:.3g} times the noise, and nothing that was tested tells "
        "why\n",
        assessment.error);
  const std::string count =
      traces == 0 ? "" : fmt::format(" ({} {})", traces, traces == 1 ? "trace" : "traces");
  if (material > 0)
    return fmt::format("Nothing that matters: differences stay below {:g} of the noise{}\n",
                       material, count);
  return "Nothing that matters: no difference is significant\n";
}

}  // namespace

std::string headline(const Problem& problem, const CompareResult& result) {
  const Assessment& base = result.base.assessment;
  if (result.structure.empty())
    return nothing_text(problem, base, result.material, result.traces.size());
  return fmt::format("What matters: {}\n", strongest_text(problem, base, result.structure));
}

std::string headline(const Problem& problem, const SearchResult& result, size_t traces) {
  std::vector<std::string> parts;
  if (!result.steps.empty()) {
    std::vector<std::string> names;
    for (const Step& step : result.steps) names.push_back(step.effect);
    const auto most =
        std::max_element(result.steps.begin(), result.steps.end(),
                         [](const Step& a, const Step& b) { return a.moved < b.moved; });
    const bool one = names.size() == 1;
    parts.push_back(fmt::format("{} {} missing; {} moves predictions by {:.2g} noise units",
                                fmt::join(names, ", "), one ? "is" : "are",
                                one ? "it" : most->effect, most->moved));
  }
  if (result.verdict == "unexplained_structure" && !result.remaining.empty())
    parts.push_back(strongest_text(problem, result.best.assessment, result.remaining) +
                    ", which no known effect explains");
  if (parts.empty()) return nothing_text(problem, result.best.assessment, result.material, traces);
  return fmt::format("What matters: {}\n", fmt::join(parts, "; "));
}

std::string traces_text(const std::vector<Structure>& structure,
                        const std::vector<Candidate>& candidates) {
  std::vector<std::string> names;
  for (const Candidate& c : candidates) names.push_back(c.effect->name);
  for (const Structure& s : structure)
    names.push_back(fmt::format("{} of {} by {}", s.moment, s.residual, s.covariate));
  if (names.empty()) return "";
  constexpr size_t kMostNamed = 6;
  const size_t count = names.size();
  names.resize(std::min(count, kMostNamed));
  return fmt::format("traces, significant but not material: {}{}\n", fmt::join(names, ", "),
                     count > kMostNamed ? ", ..." : "");
}

}  // namespace seam::measurement
