#include "measurement/report/headline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/judge/decisions.h"
#include "measurement/report/told.h"
#include "measurement/report/unnamed/unnamed_told.h"
#include "measurement/search/order.h"

namespace seam::measurement {
namespace {

// The structure that is strongest in noise units: "the mean of u_px varies with time (1.5 x
// noise)".
std::string strongest_text(const Problem& problem, const Assessment& assessment,
                           const std::vector<Structure>& structure) {
  const auto units = [&](const Structure& s) { return noise_units(problem, assessment, s); };
  const Structure& most = *std::max_element(
      structure.begin(), structure.end(),
      [&](const Structure& a, const Structure& b) { return units(a) < units(b); });
  return fmt::format("{} ({} x noise)", told_structure(problem.facts(), most),
                     two_digits(units(most)));
}

// An explanation that leaves more than this share of the error comes near to nothing.
constexpr double kNoNearer = 0.99;

// The steps, or where there are none the best candidate, as what comes nearest to an explanation.
std::string nearest_text(const SearchResult& result) {
  std::vector<std::string> names;
  for (const Step& step : result.steps) names.push_back(step.effect);
  double left = result.best.assessment.error;
  if (names.empty()) {
    const Candidate* best = nullptr;
    for (const Candidate& c : result.first.candidates) {
      const bool helps = !only_widens(*c.effect) && c.gain_ll > 0;
      if (helps && (best == nullptr || c.gain_ll > best->gain_ll)) best = &c;
    }
    if (best == nullptr) return "";
    names = {best->effect->name}, left = best->grown.assessment.error;
  }
  if (!(left < kNoNearer * result.base.assessment.error)) return "";
  return fmt::format(" Nearest: {}, which {} {:.3g} of {:.3g}.", fmt::join(names, ", "),
                     names.size() == 1 ? "leaves" : "leave", left, result.base.assessment.error);
}

// What a formula leaves, and what it is; empty where none is known.
std::string formula_sentence(const SearchResult& result) {
  if (!result.suggestion) return "";
  const Suggestion& formula = *result.suggestion;
  return fmt::format(" A formula leaves {:.3g} of {:.3g}: {}.", formula.error, formula.error_before,
                     formula.formula);
}

// The effects that only imitate a cause without a name, or where there are none what comes nearest.
std::string mimics_text(const SearchResult& result) {
  if (result.mimics.empty()) return result.steps.empty() ? nearest_text(result) : "";
  const bool one = result.mimics.size() == 1;
  return fmt::format(" Nearest: {}, which {} {:.3g} and may only imitate the cause.",
                     fmt::join(result.mimics, ", "), one ? "leaves" : "leave", result.mimics_error);
}

// A cause without a name, beside what is missing for sure: "residuals depend on row and column".
std::string unnamed_text(const SearchResult& result) {
  const UnnamedCause& cause = *result.unnamed;
  std::vector<std::string> functions;
  for (const std::vector<std::string>& covariates : cause.depends_on)
    functions.push_back(fmt::format("{}", fmt::join(covariates, " and ")));
  return fmt::format(
             "No known effect explains what depends on {} ({} x noise): {} the error from {:.3g} "
             "to "
             "{:.3g}.",
             fmt::join(functions, ", and on "), two_digits(cause.noise_units),
             functions.size() == 1 ? "a smooth function lowers" : "smooth functions lower",
             cause.error_before, cause.error_after) +
         formula_sentence(result) + splines_sentence(result) + mimics_text(result);
}

// What a step has to move to be missing for sure: beside a cause without a name many times as much
// as that and noise of unknown cause do. No step is where one is doubted: the model is another one.
double least_for_sure(const SearchResult& result) {
  double unknown = result.unnamed ? result.unnamed->noise_units : 0;
  const std::vector<std::string> noises = noises_of_unknown_cause(result);
  for (const Step& step : result.steps) {
    if (!step.doubts.empty()) return std::numeric_limits<double>::infinity();
    if (result.unnamed && std::find(noises.begin(), noises.end(), step.effect) != noises.end())
      unknown = std::max(unknown, step.moved);
  }
  return kFarAboveUnnamed * unknown;
}

// What is missing, for sure, and what fits best and is doubted: there the true cause may be another
// one.
std::string steps_text(const SearchResult& result) {
  std::vector<std::string> sure, undetermined, likely, doubtful, noises;
  const std::vector<std::string> unknown = noises_of_unknown_cause(result);
  const double least = least_for_sure(result);
  const Step* most = nullptr;
  for (const Step& step : result.steps) {
    const bool noise = std::find(unknown.begin(), unknown.end(), step.effect) != unknown.end();
    const std::string moves = fmt::format("{} ({} x noise)", step.effect, two_digits(step.moved));
    if (!step.doubts.empty()) {
      doubtful.push_back(fmt::format("{} ({})", step.effect, fmt::join(step.doubts, "; ")));
    } else if (noise) {
      noises.push_back(moves);
    } else if (step.moved < least) {
      likely.push_back(moves);
    } else if (!determines_a_value(result.best.assessment, step.effect)) {
      undetermined.push_back(step.effect);
    } else {
      sure.push_back(step.effect);
      if (most == nullptr || step.moved > most->moved) most = &step;
    }
  }
  std::vector<std::string> parts;
  if (most != nullptr)
    parts.push_back(fmt::format("{} {} missing; {} moves predictions by {} x noise",
                                fmt::join(sure, ", "), sure.size() == 1 ? "is" : "are",
                                sure.size() == 1 ? "it" : most->effect, two_digits(most->moved)));
  if (!undetermined.empty())
    parts.push_back(
        fmt::format("{} {} in the model for the others alone: the data determine no value of it",
                    fmt::join(undetermined, ", "), undetermined.size() == 1 ? "is" : "are"));
  if (!doubtful.empty())
    parts.push_back(fmt::format("{} fits best, which establishes no cause: look for another",
                                fmt::join(doubtful, " with ")));
  if (!likely.empty())
    parts.push_back(fmt::format("{} {}, which establishes nothing while a cause is unexplained",
                                fmt::join(likely, ", "), likely.size() == 1 ? "helps" : "help"));
  if (!noises.empty())
    parts.push_back(fmt::format("noise of unknown cause: {}", fmt::join(noises, ", ")));
  return fmt::format("{}", fmt::join(parts, "; "));
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
  if (!std::isfinite(assessment.error))
    return "What matters: the model predicts no finite number for some observations\n";
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
  if (result.unnamed && result.steps.empty()) return unnamed_text(result) + "\n";
  if (result.unnamed)
    return fmt::format("{} Beside it: {}\n", unnamed_text(result), steps_text(result));
  if (result.verdict == "unexplained_structure" && !result.remaining.empty())
    return fmt::format("No known effect explains this: {}.{}{}\n",
                       strongest_text(problem, result.best.assessment, result.remaining),
                       formula_sentence(result),
                       result.mimics.empty() ? nearest_text(result) : mimics_text(result));
  if (result.steps.empty())
    return nothing_text(problem, result.best.assessment, result.material, traces);
  const bool doubted = result.verdict == "unexplained_structure";
  return fmt::format("{}: {}\n",
                     doubted ? "No known effect explains this for sure" : "What matters",
                     steps_text(result));
}

const std::vector<Structure>& traces_told(const SearchResult& result) {
  return result.verdict == "unexplained_structure" ? result.remaining_traces : result.base_traces;
}

std::string diagnose_headline(const Problem& problem, const SearchResult& result) {
  return headline(problem, result,
                  traces_told(result).size() + traces_of(result.first.candidates).size());
}

std::string discover_headline(const Problem& problem, const SearchResult& result) {
  return headline(problem, result, result.remaining_traces.size() + result.last_traces.size());
}

std::string traces_text(const Facts& facts, const std::vector<Structure>& structure,
                        const std::vector<Candidate>& candidates) {
  std::vector<std::string> names;
  for (const Candidate& c : candidates) add_once(names, c.effect->name);
  for (const Structure& s : structure) names.push_back(told_structure(facts, s));
  if (names.empty()) return "";
  constexpr size_t kMostNamed = 6;
  const size_t count = names.size();
  names.resize(std::min(count, kMostNamed));
  return fmt::format("traces, significant but not material: {}{}\n", fmt::join(names, ", "),
                     count > kMostNamed ? ", ..." : "");
}

}  // namespace seam::measurement
