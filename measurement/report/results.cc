#include "measurement/report/results.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "effects/kind.h"
#include "measurement/check/doubts.h"
#include "measurement/report/curves/curves_told.h"
#include "measurement/report/figures_told.h"
#include "measurement/report/headline.h"
#include "measurement/report/target_told.h"
#include "measurement/report/told.h"
#include "measurement/report/trust/trust.h"
#include "measurement/report/unnamed/unnamed_told.h"
#include "measurement/search/kept.h"
#include "measurement/search/looked_for.h"

namespace seam::measurement {
namespace {

// What the set and the model cannot say, and what may be wrong with them.
struct Notes {
  std::string warnings, others;
};

Notes notes_of(const Problem& problem, const Model& model) {
  Notes notes;
  for (const auto& list : {problem.facts().notes, problem.remarks(model)}) {
    for (const std::string& note : list)
      (note.starts_with("warning") ? notes.warnings : notes.others) += note + "\n";
  }
  return notes;
}

std::string findings_text(const Problem& problem, const Assessment& assessment) {
  std::string text;
  for (const Finding& finding : problem.findings(assessment.model)) text += finding.text + "\n";
  return text;
}

// How far free predictions go wrong; with a second model, before and after.
std::string free_text(const Problem& problem, const Assessment& before,
                      const Assessment* after = nullptr) {
  const std::vector<FreeError> first = free_errors(problem, before);
  const std::vector<FreeError> then =
      after ? free_errors(problem, *after) : std::vector<FreeError>();
  std::string text;
  for (size_t i = 0; i < first.size(); ++i) {
    const auto told = [](const FreeError& error) {
      const std::string end =
          error.over == "run" ? fmt::format(" ({:.3g} at its end)", error.last) : "";
      return fmt::format("{:.3g}{}", error.rms, end);
    };
    text += fmt::format("  predicted freely over {:4s} {:10s} {}", first[i].over, first[i].residual,
                        told(first[i]));
    if (i < then.size()) text += " -> " + told(then[i]);
    text += " rms\n";
  }
  return text;
}

// An error that rises by less is the same in the figures that are printed.
constexpr double kSameError = 1.001;

// Why a step is taken with which the error of held-out groups rises.
std::string rise_text(const SearchResult& result, const Step& step) {
  const bool goes_on = &step != &result.steps.back() &&
                       result.best.assessment.error < kSameError * step.error_before;
  return goes_on ? "      the error rises with it and falls with the steps that follow\n"
                 : "      the error of held-out groups rises with it; all groups together are "
                   "likelier with it\n";
}

// Questions about what the columns mean come before any result.
std::string first_lines(const std::string& headline, const Doubts& doubts) {
  Doubts others = doubts;
  std::erase_if(others, [](const std::string& doubt) { return doubt.starts_with(kQuestion); });
  return with_questions(headline, doubts) + doubts_text(others);
}

// Why the error is not that of `compare`, where it is not.
std::string outlier_text(const SearchResult& result) {
  if (result.steps.empty() || result.outliers.empty()) return "";
  return fmt::format(
      "{} {} left out as outliers of the best model found (compare leaves out those of the model "
      "given, so that its error differs)\n",
      result.outliers.size(), result.outliers.size() == 1 ? "residual" : "residuals");
}

std::string candidate_text(int rank, const Candidate& candidate) {
  const Assessment& after = candidate.grown.assessment;
  std::string text =
      fmt::format("{:2d}. {:24s} error {:.4f}   log-likelihood {:+.4g}   p {} {:.2g}   {}\n", rank,
                  candidate.effect->name, after.error, candidate.gain_ll,
                  candidate.p_value > 1e-300 ? "=" : "<", candidate.p_value,
                  told_values(after, candidate.effect->name));
  for (const auto& companion : candidate.companions)
    text +=
        fmt::format("    with {:24s} {}\n", companion->name, told_values(after, companion->name));
  for (const std::string& other : candidate.indistinguishable_from)
    text += fmt::format("      not separated from {} by these data\n", other);
  if (!candidate.stands_in_for.empty())
    text +=
        fmt::format("      alone it stands in for {}\n", fmt::join(candidate.stands_in_for, ", "));
  return text;
}

// The effects of the model found in the order of its steps, then others that help alone.
std::string candidates_text(const std::vector<Candidate>& candidates) {
  constexpr int kMost = 5;
  std::string found, others;
  int rank = 0;
  for (const Candidate& candidate : candidates) {
    if (++rank > kMost || !candidate.significant) break;
    (candidate.found ? found : others) += candidate_text(rank, candidate);
  }
  if (!found.empty())
    found =
        "effects found, in the order of the steps; each figure is of the effect alone:\n" + found;
  if (!others.empty())
    others = "other effects that help alone, by the log-likelihood of held-out groups:\n" + others;
  return found + others;
}

// A formula for what no known effect explains; empty where none is known.
std::string formula_text(const SearchResult& result) {
  if (!result.suggestion) return "";
  const Suggestion& formula = *result.suggestion;
  std::string numbers;
  for (const auto& [parameter, value, sigma] : formula.numbers)
    numbers += fmt::format("{}{} = {:.4g} +- {:.2g}", numbers.empty() ? "" : ", ", parameter, value,
                           sigma);
  return fmt::format(
      "formula: {}\n  {}\n  error {:.4f} -> {:.4f} on held-out groups{}\n", formula.formula,
      numbers, formula.error_before, formula.error,
      formula.beside.empty() ? "" : fmt::format(", beside {}", fmt::join(formula.beside, ", ")));
}

// Of what no known effect explains: what to vary, by the strongest structure of which a user can.
std::string advice_on(const Problem& problem, const std::vector<Structure>& structure) {
  if (structure.empty()) return "";
  const Structure* told = &structure.front();
  std::string ways;
  for (const Structure& s : structure) {
    ways = what_to_vary(problem.facts(), s.covariate);
    if (!ways.empty()) told = &s;
    if (!ways.empty()) break;
  }
  return fmt::format(
      "No known effect explains that {}: {}write an effect for it (seam diagnose --suggest).",
      told_structure(problem.facts(), *told), ways.empty() ? "" : ways + ", or ");
}

}  // namespace

std::string advice_for(const Problem& problem, const SearchResult& result) {
  std::string text;
  const auto say = [&](const std::string& sentence) {
    if (!sentence.empty() && text.find(sentence) == std::string::npos)
      text += (text.empty() ? "" : " ") + sentence;
  };
  for (const Step& step : result.steps) {
    for (const std::string& other : step.indistinguishable_from) {
      const std::string known = problem.advice(step.effect, other);
      say(known.empty() ? fmt::format("{} and {} look alike in these data: measure over a wider "
                                      "range of what they depend on.",
                                      step.effect, other)
                        : known);
    }
  }
  if (result.verdict == "unexplained_structure") say(advice_on(problem, result.remaining));
  return text;
}

std::vector<FreeError> free_errors(const Problem& problem, const Assessment& assessment) {
  if (!assessment.valid) return {};
  const auto& folds = problem.folds();
  return problem.free_prediction(assessment.model,
                                 folds.size() == 1 ? folds.front() : problem.all_groups());
}

std::string doubts_text(const Doubts& doubts) {
  std::string text;
  for (const std::string& doubt : doubts) text += doubt + "\n";
  return text;
}

std::string with_questions(const std::string& headline, const Doubts& doubts) {
  std::string text;
  for (const std::string& doubt : doubts) {
    if (doubt.starts_with(kQuestion))
      text += doubt.substr(kQuestion.size()) + (doubt.ends_with('?') ? " " : ". ");
  }
  return text.empty() ? headline : "First: " + text + "As the set stands: " + headline;
}

std::string compare_text(const Problem& problem, const CompareResult& result,
                         const Doubts& doubts) {
  const Assessment& base = result.base.assessment;
  const Notes notes = notes_of(problem, base.model);
  std::string text = first_lines(headline(problem, result), doubts);
  if (!base.held.valid && std::isfinite(base.error))
    text += fmt::format(
        "Some observations have no prediction with this model{}: the error below leaves them out; "
        "seam check --model MODEL names them.\n",
        problem.facts().set.kind == effects::kPoints
            ? " (points behind the camera, or beyond the angle at which the lens folds back)"
            : "");
  text += fmt::format(
      "{}: {} residuals in {} groups\nerror on held-out groups {:.4f} (1.0 is the noise)\n",
      problem.facts().title, count_used(problem), problem.facts().groups.size(), base.error);
  for (size_t c = 0; c < problem.facts().channels.size(); ++c) {
    if (base.held.native_count[c] == 0) continue;
    text += fmt::format("  {:14s} {:.5g} rms, noise {:.5g}{}\n", problem.facts().channels[c].name,
                        base.held.native[c], problem.facts().channels[c].noise,
                        problem.facts().channels[c].estimated ? " (estimated)" : "");
  }
  text += free_text(problem, base) + findings_text(problem, base) + notes.warnings + notes.others;
  if (!result.outliers.empty())
    text += fmt::format(
        "{} residuals left out as outliers of this model (diagnose, which may find a better one, "
        "leaves out that one's, so that its error differs)\n",
        result.outliers.size());
  if (result.outlier_share > kMostOutliers)
    text += fmt::format("{:.0f} % of the residuals look like outliers: none is left out\n",
                        100 * result.outlier_share);
  if (const std::string why = problem.no_outliers_because(); !why.empty())
    text += fmt::format("no outliers are looked for: {}\n", why);
  text += result.structure.empty()
              ? result.traces.empty() ? "no significant structure\n" : "no structure that matters\n"
              : "structure of the residuals:\n" + structure_lines(problem, base, result.structure);
  return text + traces_text(problem.facts(), result.traces, {}) + figures_text(problem, base) +
         curves_text(problem, base.model);
}

std::string diagnose_text(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts) {
  const bool unexplained = result.verdict == "unexplained_structure";
  const std::vector<Candidate> traces = traces_of(result.first.candidates);
  const Notes notes = notes_of(problem, result.best.assessment.model);
  std::string text = first_lines(diagnose_headline(problem, result), doubts);
  text += fmt::format("{}: error {:.4f} on held-out groups (1.0 is the noise)\n",
                      problem.facts().title, result.base.assessment.error);
  text += free_text(problem, result.base.assessment) + notes.warnings + outlier_text(result);
  text += fmt::format("verdict: {}\n", result.verdict);
  if (!result.mimics.empty())
    text += fmt::format("may only imitate the unknown cause: {}\n", fmt::join(result.mimics, ", "));
  text += formula_text(result) + splines_text(result);
  text += candidates_text(result.first.candidates);
  const auto& structure = unexplained ? result.remaining : result.base_structure;
  if (!structure.empty()) {
    text +=
        unexplained ? "what remains after all known effects:\n" : "structure of the residuals:\n";
    text +=
        structure_lines(problem, (unexplained ? result.best : result.base).assessment, structure);
  }
  text += traces_text(problem.facts(), traces_told(result), traces);
  text += findings_text(problem, result.best.assessment);
  const std::string advice = advice_for(problem, result);
  if (!advice.empty()) text += "advice: " + advice + "\n";
  return text + looked_for_text(looked_for(problem, result)) +
         trust_text(trust_in(problem, result)) + notes.others +
         figures_text(problem, result.base.assessment) +
         curves_text(problem, result.base.assessment.model);
}

std::string discover_text(const Problem& problem, const SearchResult& result,
                          const Doubts& doubts) {
  const Notes notes = notes_of(problem, result.best.assessment.model);
  std::string text = first_lines(discover_headline(problem, result), doubts);
  text += fmt::format("{}: error {:.4f} on held-out groups before\n", problem.facts().title,
                      result.base.assessment.error);
  text += notes.warnings + outlier_text(result);
  for (const Step& step : result.steps) {
    text += fmt::format("  + {:24s} {:.4f} -> {:.4f}   {}\n", step.effect, step.error_before,
                        step.error_after, told_values(result.best.assessment, step.effect));
    if (step.error_after > kSameError * step.error_before) text += rise_text(result, step);
    for (const std::string& doubt : step.doubts) text += fmt::format("      doubted: {}\n", doubt);
    for (const std::string& other : step.indistinguishable_from)
      text += fmt::format("      not separated from {} by these data\n", other);
  }
  if (!result.mimics.empty())
    text += fmt::format("  not added, since an unknown cause explains more: {}\n",
                        fmt::join(result.mimics, ", "));
  text += formula_text(result) + splines_text(result);
  for (const KeptTrace& kept : result.kept) {
    text +=
        fmt::format("  kept, a trace: {}   {}; without it {} would be {:.0f} standard errors off\n",
                    kept.effect, told_values(result.best.assessment, kept.effect),
                    moved_value(result, kept), kept.errors);
  }
  text += fmt::format("error {:.4f}, {}\n", result.best.assessment.error,
                      result.verdict != "unexplained_structure" ? "adequate"
                      : result.remaining.empty() && !result.unnamed && result.mimics.empty()
                          ? "no cause is established"
                          : "structure remains that no known effect explains");
  if (result.errors_widened > 1.5)
    text += fmt::format(
        "standard errors are up to {:.1f} times those of independent noise, since groups differ by "
        "that much\n",
        result.errors_widened);
  text += free_text(problem, result.base.assessment, &result.best.assessment) +
          findings_text(problem, result.best.assessment);
  text += target_text(problem, result.best.assessment.model);
  if (result.verdict == "unexplained_structure")
    text += structure_lines(problem, result.best.assessment, result.remaining);
  return text + traces_text(problem.facts(), result.remaining_traces, result.last_traces) +
         looked_for_text(looked_for(problem, result)) + trust_text(trust_in(problem, result)) +
         notes.others + figures_text(problem, result.best.assessment) +
         curves_text(problem, result.best.assessment.model);
}

}  // namespace seam::measurement
