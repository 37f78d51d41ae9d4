#include "measurement/search/looked_for.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "measurement/problem/neighbour.h"

namespace seam::measurement {
namespace {

constexpr const char* kNothing = "nothing";
constexpr const char* kTrace = "trace";
constexpr const char* kFound = "found";
constexpr const char* kNotTested = "not tested";

void add_functions(const SearchResult& result, std::vector<LookedFor>& list) {
  constexpr const char* kWhat = "smooth function";
  if (result.functions.empty())
    list.push_back({kWhat, {}, kNotTested, "this kind has no residual of each row"});
  for (const TriedFunction& function : result.functions) {
    const auto is_it = [&](const auto& names) { return names == function.covariates; };
    const bool found = result.unnamed && std::any_of(result.unnamed->depends_on.begin(),
                                                     result.unnamed->depends_on.end(), is_it);
    LookedFor entry{kWhat, function.covariates, found ? kFound : kNothing};
    entry.why = fmt::format("log-evidence {:+.3g}", function.log_evidence);
    if (!function.is_testable) {
      entry.outcome = kNotTested;
      entry.why = "it is constant, or unknowns and errors that rows share can follow it";
    }
    list.push_back(std::move(entry));
  }
}

void add_formula(const SearchResult& result, std::vector<LookedFor>& list) {
  LookedFor entry{"formula", {}, result.suggestion ? kFound : kNothing};
  if (result.suggestion) entry.why = result.suggestion->formula;
  if (!result.formula_sought) {
    entry.outcome = kNotTested;
    entry.why = "the effects found leave nothing but noise";
  }
  list.push_back(std::move(entry));
}

// What the tests of structure say of one covariate after the last step.
LookedFor structure_of(const SearchResult& result, const std::string& what,
                       const std::string& covariate) {
  const auto has = [&](const std::vector<Structure>& list) {
    return std::any_of(list.begin(), list.end(), [&](const Structure& structure) {
      return structure.covariate == covariate;
    });
  };
  return {what,
          {covariate},
          has(result.remaining)          ? kFound
          : has(result.remaining_traces) ? kTrace
                                         : kNothing};
}

// Kinds with tests of their own have no covariates by row: what these found is listed.
void add_found(const std::vector<Structure>& structures, const char* outcome,
               std::vector<LookedFor>& list) {
  for (const Structure& structure : structures) {
    const bool listed = std::any_of(list.begin(), list.end(), [&](const LookedFor& entry) {
      return entry.covariates == std::vector<std::string>{structure.covariate};
    });
    if (!listed && structure.covariate != kPixelNeighbour)
      list.push_back({"mean and spread", {structure.covariate}, outcome});
  }
}

void add_structure(const Facts& facts, const SearchResult& result, std::vector<LookedFor>& list) {
  for (const Covariate& covariate : facts.covariates) {
    const bool label = covariate.type == Covariate::Type::category;
    list.push_back(
        structure_of(result, label ? "mean of each label" : "mean and spread", covariate.name));
  }
  LookedFor neighbours = structure_of(result, "neighbours in time", kNeighbour);
  neighbours.covariates.clear();
  if (facts.series_of_row.empty() || !facts.tests_neighbours) {
    neighbours.outcome = kNotTested;
    neighbours.why = "rows of this set do not follow one another";
  }
  list.push_back(std::move(neighbours));
  if (facts.covariates.empty()) {
    add_found(result.remaining, kFound, list);
    add_found(result.remaining_traces, kTrace, list);
  }
  LookedFor pixels = structure_of(result, "neighbours in the image", kPixelNeighbour);
  if (pixels.outcome == kNothing && !facts.covariates.empty()) return;
  pixels.covariates.clear();
  list.push_back(std::move(pixels));
}

void add_mixtures(const Problem& problem, const SearchResult& result,
                  std::vector<LookedFor>& list) {
  const auto is_mixture = [](const EffectDefinition& effect) {
    return effect.errors == effects::Errors::now_and_then;
  };
  for (const Candidate& candidate : result.first.candidates) {
    if (!is_mixture(*candidate.effect)) continue;
    const std::string& name = candidate.effect->name;
    const bool taken = std::any_of(result.steps.begin(), result.steps.end(),
                                   [&](const Step& step) { return step.effect == name; });
    list.push_back({"mixture", {name}, taken ? kFound : candidate.trace ? kTrace : kNothing});
  }
  LookedFor gross{"gross errors", {}, result.outliers.empty() ? kNothing : kFound};
  if (!result.outliers.empty())
    gross.why = fmt::format("{} residuals left out", result.outliers.size());
  if (const std::string why = problem.no_outliers_because(); !why.empty()) {
    gross.outcome = kNotTested;
    gross.why = why;
  }
  list.push_back(std::move(gross));
}

// Effects that could stand in the place of a step.
void add_ties(const SearchResult& result, std::vector<LookedFor>& list) {
  if (result.ties_sought || result.steps.empty()) return;
  list.push_back({"ties",
                  {},
                  kNotTested,
                  "a cause is unexplained: no step is established, nor what could stand for it"});
}

std::string name_of(const LookedFor& entry) {
  if (entry.covariates.empty()) return entry.what;
  return fmt::format("{} of {}", entry.what, fmt::join(entry.covariates, " and "));
}

}  // namespace

std::vector<LookedFor> looked_for(const Problem& problem, const SearchResult& result) {
  std::vector<LookedFor> list;
  add_functions(result, list);
  add_formula(result, list);
  add_structure(problem.facts(), result, list);
  add_mixtures(problem, result, list);
  add_ties(result, list);
  return list;
}

std::string looked_for_text(const std::vector<LookedFor>& list) {
  constexpr size_t kMost = 3;
  std::vector<std::string> found, not_tested;
  size_t nothing = 0, traces = 0;
  for (const LookedFor& entry : list) {
    nothing += entry.outcome == kNothing, traces += entry.outcome == kTrace;
    if (entry.outcome == kFound) found.push_back(name_of(entry));
    if (entry.outcome == kNotTested) not_tested.push_back(name_of(entry));
  }
  const auto named = [&](std::vector<std::string> names) {
    const size_t count = names.size();
    names.resize(std::min(count, kMost));
    return fmt::format("{}{}", fmt::join(names, ", "), count > kMost ? ", ..." : "");
  };
  std::string text = fmt::format(
      "looked for beside known effects: {} found{}{}, {} trace{}, {} without result", found.size(),
      found.empty() ? "" : ": ", named(found), traces, traces == 1 ? "" : "s", nothing);
  if (!not_tested.empty())
    text += fmt::format("; {} not tested: {}", not_tested.size(), named(not_tested));
  return text + " (--json: looked_for)\n";
}

}  // namespace seam::measurement
