#include "measurement/search/models/add_effects.h"

#include <algorithm>
#include <cmath>

#include "measurement/fitting/group_scatter.h"
#include "measurement/judge/decisions.h"
#include "measurement/search/models/compare.h"
#include "measurement/search/told_apart.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

effects::HistoryStep history_step(const Problem& problem, const AddResult& result) {
  return {.effect = result.effect,
          .parameters = result.parameters,
          .data_fingerprint = problem.facts().fingerprint,
          .data = problem.facts().title,
          .error_before = result.error_before,
          .error_after = result.error_after};
}

// Refuses an effect that can stand in no model like this, whatever the data say.
void check_place(const Problem& problem, const effects::EffectDefinition& effect,
                 const Model& model) {
  if (!problem.acts(effect)) {
    const std::string reads = effect.columns.empty() ? ""
                                                     : fmt::format(" without the column {}",
                                                                   fmt::join(effect.columns, ", "));
    throw InputError(fmt::format("effect '{}' does not act on measurements of kind {}{}",
                                 effect.name, problem.facts().kind(), reads));
  }
  if (const std::string base = effects::missing_base(effect, model); !base.empty()) {
    throw InputError(
        fmt::format("effect '{}' acts in a model with '{}', expected one", effect.name, base));
  }
  if (const effects::ModelEffect* other = effects::excluding(effect, model)) {
    const std::string& name = other->definition->name;
    throw InputError(
        fmt::format("effects '{0}' and '{1}' exclude each other, and the model has '{1}': take "
                    "'{1}' out of it, "
                    "and add '{0}', or let `seam discover` choose between them",
                    effect.name, name));
  }
}

}  // namespace

NamedValues parameters_of(const Assessment& assessment, const std::string& effect) {
  NamedValues parameters;
  const effects::ModelEffect& entry = *assessment.model.find(effect);
  for (size_t i = 0; i < entry.parameters.size(); ++i) {
    effects::ParameterValue value{.value = entry.parameters[i].value};
    const auto k = index_of(assessment.unknowns, {effect, i});
    if (k && std::isfinite(assessment.fit.sigma[*k])) value.sigma = assessment.fit.sigma[*k];
    parameters.emplace_back(entry.definition->parameters[i].name, value);
  }
  return parameters;
}

AddResult add_effects(Problem& problem, const Model& model, const EffectList& effects) {
  const CompareResult before = compare(problem, model);
  Grown grown = before.base;
  AddResult result{.error_before = before.base.assessment.error};
  for (const auto& effect : effects) {
    check_place(problem, *effect, grown.assessment.model);
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
  widen_by_group_scatter(problem, kMisfit, grown.assessment);
  write_sigmas(result.model, grown.assessment.unknowns, grown.assessment.fit);
  for (const auto& effect : effects) {
    result.effect += (result.effect.empty() ? "" : ", ") + effect->name;
    for (auto& parameter : parameters_of(grown.assessment, effect->name))
      result.parameters.push_back(std::move(parameter));
  }
  for (const effects::ModelEffect& given : model.effects()) {
    const std::string& name = given.definition->name;
    if (!result.model.has(name)) result.replaced.push_back(name);
  }
  result.model.append_history(history_step(problem, result));
  result.assessment = std::move(grown.assessment);
  return result;
}

AddResult refit_all(Problem& problem, const Model& model) {
  const CompareResult before = compare(problem, model);
  std::vector<Unknown> unknowns;
  for (const effects::ModelEffect& effect : before.base.assessment.model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const bool acts = problem.acts(*effect.definition) &&
                        problem.not_testable(model, *effect.definition, i).empty();
      const effects::Parameter& parameter = effect.definition->parameters[i];
      const bool stays =
          parameter.integer || (parameter.stated && !effect.parameters[i].refitted());
      if (!stays && acts) unknowns.push_back({effect.definition->name, i});
    }
  }
  std::vector<NotTestable> untold;
  unknowns = told_apart(problem, before.base.assessment.model, unknowns, untold);
  Assessment after = assess(problem, before.base.assessment.model, unknowns);
  widen_by_group_scatter(problem, kMisfit, after);
  AddResult result{.model = after.model,
                   .error_before = before.base.assessment.error,
                   .error_after = after.error,
                   .not_testable = std::move(untold)};
  write_sigmas(result.model, after.unknowns, after.fit);
  for (const effects::ModelEffect& effect : after.model.effects()) {
    for (auto& [name, value] : parameters_of(after, effect.definition->name)) {
      if (value.sigma) result.parameters.emplace_back(effect.definition->name + "." + name, value);
    }
  }
  result.model.append_history(history_step(problem, result));
  result.assessment = std::move(after);
  return result;
}

Model discovered_model(const Problem& problem, const Model& start, const SearchResult& result) {
  if (result.steps.empty() && result.kept.empty()) {
    Model model = result.base.assessment.model;
    write_sigmas(model, result.base.assessment.unknowns, result.base.assessment.fit);
    return model;
  }
  Model model = result.best.assessment.model;
  model.set_name(start.name());
  write_sigmas(model, result.best.assessment.unknowns, result.best.assessment.fit);
  const auto note = [&](const auto& came, const Assessment& after) {
    const AddResult entry{.effect = came.effect,
                          .parameters = parameters_of(after, came.effect),
                          .error_before = came.error_before,
                          .error_after = came.error_after};
    model.append_history(history_step(problem, entry));
  };
  for (const Step& step : result.steps) note(step, step.after);
  for (const KeptTrace& kept : result.kept) note(kept, result.best.assessment);
  return model;
}

}  // namespace seam::measurement
