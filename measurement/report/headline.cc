#include "measurement/report/headline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

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

std::string nothing_text(const Assessment& assessment, double material, size_t traces) {
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
  if (result.structure.empty()) return nothing_text(base, result.material, result.traces.size());
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
  if (parts.empty()) return nothing_text(result.best.assessment, result.material, traces);
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
