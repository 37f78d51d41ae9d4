#include "measurement/report/results.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

std::vector<std::pair<std::string, effects::ParameterValue>> parameters_of(
    const Assessment& assessment, const std::string& effect) {
  std::vector<std::pair<std::string, effects::ParameterValue>> parameters;
  const effects::ModelEffect& entry = *assessment.model.find(effect);
  for (size_t i = 0; i < entry.parameters.size(); ++i) {
    effects::ParameterValue value{.value = entry.parameters[i].value};
    for (size_t k = 0; k < assessment.unknowns.size(); ++k) {
      if (assessment.unknowns[k].effect == effect && assessment.unknowns[k].parameter == i &&
          std::isfinite(assessment.fit.sigma[k])) {
        value.sigma = assessment.fit.sigma[k];
      }
    }
    parameters.emplace_back(entry.definition->parameters[i].name, value);
  }
  return parameters;
}

effects::HistoryStep history_step(const Problem& problem, const AddResult& result) {
  return {.effect = result.effect,
          .parameters = result.parameters,
          .data_fingerprint = problem.facts().fingerprint,
          .data = problem.facts().title,
          .error_before = result.error_before,
          .error_after = result.error_after};
}

std::string structure_line(const Structure& s) {
  return fmt::format("  {:14s} {:6s} depends on {:24s} {:10.4g}   p = {:.2g}\n", s.residual,
                     s.moment, s.covariate, s.strength, s.p_value);
}

std::string parameter_text(
    const std::vector<std::pair<std::string, effects::ParameterValue>>& parameters) {
  std::string text;
  for (const auto& [name, value] : parameters) {
    text += fmt::format("{}{} = {:.6g}", text.empty() ? "" : ", ", name, value.value);
    if (value.sigma) text += fmt::format(" +- {:.2g}", *value.sigma);
  }
  return text;
}

// The strongest structures, one line for each covariate.
std::string structure_text(const std::vector<Structure>& structure) {
  std::string text;
  size_t lines = 0;
  for (const Structure& s : structure) {
    if (lines++ == 8) break;
    text += structure_line(s);
  }
  return text;
}

}  // namespace

CompareResult compare(Problem& problem, const Model& model) {
  problem.check_model(model);
  problem.prepare(model);
  CompareResult result;
  SearchResult marks;
  problem.leave_out({});
  Assessment assessment = assess(problem, model, refitted_unknowns(model));
  for (int round = 0; round < 3 && mark_outliers(problem, assessment.model, marks); ++round) {
    assessment = assess(problem, model, refitted_unknowns(model));
  }
  result.outliers = marks.outliers;
  result.outlier_share = marks.outlier_share;
  result.base.assessment = std::move(assessment);
  result.structure = significant_structure(problem, result.base);
  return result;
}

AddResult add_effects(Problem& problem, const Model& model, const EffectList& effects) {
  const CompareResult before = compare(problem, model);
  Grown grown = before.base;
  AddResult result{.error_before = before.base.assessment.error};
  for (const auto& effect : effects) {
    if (!problem.acts(*effect)) {
      throw InputError(fmt::format("effect '{}' does not act on measurements of kind {}",
                                   effect->name, problem.facts().kind));
    }
    grown.assessment.model.remove(effect->name);
    std::erase_if(grown.assessment.unknowns,
                  [&](const Unknown& u) { return u.effect == effect->name; });
    auto candidate = try_effect(problem, grown, effect, result.not_testable);
    if (!candidate) {
      std::string why = "these data say nothing of it";
      for (const NotTestable& reason : result.not_testable) {
        if (reason.effect == effect->name) why = reason.why;
      }
      throw InputError(fmt::format("effect '{}' cannot be fitted: {}", effect->name, why));
    }
    grown = std::move(candidate->grown);
  }
  // The same outliers before and after: those of the better model.
  SearchResult marks;
  if (mark_outliers(problem, grown.assessment.model, marks)) {
    grown.assessment = assess(problem, grown.assessment.model, grown.assessment.unknowns);
    result.error_before = assess(problem, model, refitted_unknowns(model)).error;
  }
  result.error_after = grown.assessment.error;
  result.model = grown.assessment.model;
  write_sigmas(result.model, grown.assessment.unknowns, grown.assessment.fit);
  for (const auto& effect : effects) {
    result.effect += (result.effect.empty() ? "" : ", ") + effect->name;
    for (auto& parameter : parameters_of(grown.assessment, effect->name))
      result.parameters.push_back(std::move(parameter));
  }
  result.model.append_history(history_step(problem, result));
  return result;
}

AddResult refit_all(Problem& problem, const Model& model) {
  const CompareResult before = compare(problem, model);
  std::vector<Unknown> unknowns;
  for (const effects::ModelEffect& effect : before.base.assessment.model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const bool acts = problem.acts(*effect.definition) &&
                        problem.not_testable(model, *effect.definition, i).empty();
      if (!effect.definition->parameters[i].integer && acts)
        unknowns.push_back({effect.definition->name, i});
    }
  }
  Assessment after = assess(problem, before.base.assessment.model, unknowns);
  AddResult result{.model = after.model,
                   .error_before = before.base.assessment.error,
                   .error_after = after.error};
  write_sigmas(result.model, after.unknowns, after.fit);
  for (const effects::ModelEffect& effect : after.model.effects()) {
    for (auto& [name, value] : parameters_of(after, effect.definition->name)) {
      if (value.sigma) result.parameters.emplace_back(effect.definition->name + "." + name, value);
    }
  }
  result.model.append_history(history_step(problem, result));
  return result;
}

Model discovered_model(const Problem& problem, const Model& start, const SearchResult& result) {
  if (result.steps.empty()) {
    Model model = result.base.assessment.model;
    write_sigmas(model, result.base.assessment.unknowns, result.base.assessment.fit);
    return model;
  }
  Model model = result.best.assessment.model;
  model.set_name(start.name());
  write_sigmas(model, result.best.assessment.unknowns, result.best.assessment.fit);
  for (const Step& step : result.steps) {
    const AddResult entry{.effect = step.effect,
                          .parameters = parameters_of(step.after, step.effect),
                          .error_before = step.error_before,
                          .error_after = step.error_after};
    model.append_history(history_step(problem, entry));
  }
  return model;
}

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
  if (result.verdict == "unexplained_structure" && !result.remaining.empty()) {
    const Structure& worst = result.remaining.front();
    say(
        fmt::format("The {} of {} depends on {}, which no known effect explains: vary {} alone, or "
                    "write an effect for it "
                    "(seam diagnose --suggest).",
                    worst.moment, worst.residual, worst.covariate, worst.covariate));
  }
  return text;
}

std::string compare_text(const Problem& problem, const CompareResult& result) {
  const Assessment& base = result.base.assessment;
  std::string text = fmt::format(
      "{}: {} residuals in {} groups\nerror on held-out groups {:.4f} (1.0 is the noise)\n",
      problem.facts().title, count_used(problem), problem.facts().groups.size(), base.error);
  for (size_t c = 0; c < problem.facts().channels.size(); ++c) {
    text += fmt::format("  {:14s} {:.5g} rms, noise {:.5g}{}\n", problem.facts().channels[c].name,
                        base.held.native[c], problem.facts().channels[c].noise,
                        problem.facts().channels[c].estimated ? " (estimated)" : "");
  }
  if (!result.outliers.empty())
    text += fmt::format("{} residuals left out as outliers\n", result.outliers.size());
  if (result.outlier_share > 0.1)
    text += fmt::format("{:.0f} % of the residuals look like outliers: none is left out\n",
                        100 * result.outlier_share);
  text += result.structure.empty()
              ? "no significant structure\n"
              : "structure of the residuals:\n" + structure_text(result.structure);
  return text;
}

std::string diagnose_text(const Problem& problem, const SearchResult& result) {
  std::string text =
      fmt::format("{}: error {:.4f} on held-out groups (1.0 is the noise)\nverdict: {}\n",
                  problem.facts().title, result.base.assessment.error, result.verdict);
  int rank = 0;
  for (const Candidate& candidate : result.first.candidates) {
    if (++rank > 5 || !candidate.significant) break;
    text += fmt::format(
        "{:2d}. {:24s} error {:.4f}   p = {:.2g}   {}\n", rank, candidate.effect->name,
        candidate.grown.assessment.error, candidate.p_value,
        parameter_text(parameters_of(candidate.grown.assessment, candidate.effect->name)));
    for (const std::string& other : candidate.indistinguishable_from)
      text += fmt::format("      these data cannot tell it from {}\n", other);
  }
  const auto& structure =
      result.verdict == "unexplained_structure" ? result.remaining : result.base_structure;
  if (!structure.empty()) {
    text += result.verdict == "unexplained_structure" ? "what remains after all known effects:\n"
                                                      : "structure of the residuals:\n";
    text += structure_text(structure);
  }
  const std::string advice = advice_for(problem, result);
  if (!advice.empty()) text += "advice: " + advice + "\n";
  return text;
}

std::string discover_text(const Problem& problem, const SearchResult& result) {
  std::string text = fmt::format("{}: error {:.4f} on held-out groups before\n",
                                 problem.facts().title, result.base.assessment.error);
  for (const Step& step : result.steps) {
    text += fmt::format("  + {:24s} {:.4f} -> {:.4f}   {}\n", step.effect, step.error_before,
                        step.error_after,
                        parameter_text(parameters_of(result.best.assessment, step.effect)));
  }
  text += fmt::format("error {:.4f}, {}\n", result.best.assessment.error,
                      result.verdict == "unexplained_structure"
                          ? "structure remains that no known effect explains"
                          : "adequate");
  if (result.verdict == "unexplained_structure") text += structure_text(result.remaining);
  return text;
}

}  // namespace seam::measurement
