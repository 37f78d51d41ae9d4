#include "measurement/search/candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/fitting/foretaste.h"
#include "measurement/search/told_apart.h"

namespace seam::measurement {
namespace {

using effects::Parameter;
using effects::ParameterValue;

}  // namespace

Model with_effect(Model model, const Prospect& prospect, const std::vector<double>& values) {
  effects::remove_replaced(*prospect.effect, model);
  size_t at = 0;
  const auto add = [&](const std::shared_ptr<const EffectDefinition>& effect) {
    std::vector<ParameterValue> parameters;
    for (const Parameter& p : effect->parameters) {
      const double small = p.stated || p.integer ? p.neutral : p.neutral + 0.05 * p.scale;
      parameters.push_back({.value = at < values.size() ? values[at] : small});
      ++at;
    }
    model.set(effect, std::move(parameters));
  };
  add(prospect.effect);
  for (const auto& companion : prospect.companions) add(companion);
  return model;
}

namespace {

struct Fitted {
  Grown grown;
  double most_ll = 0;  // See Candidate.
};

// Counts are not fitted but tried: the best two go on.
std::vector<std::vector<double>> best_counts(const Problem& problem, const Grown& base,
                                             const Prospect& prospect,
                                             const std::vector<std::vector<double>>& starts) {
  // Effects of spread do not change which of them fits the mean, and would cost most of the time. A
  // converter's steps are another thing: what noise leaves of them is all that is seen.
  Model plain = base.assessment.model;
  for (const effects::ModelEffect& other : base.assessment.model.effects()) {
    if (other.definition->spread_only && prospect.effect->stage != effects::Stage::sensor)
      plain.remove(other.definition->name);
  }
  const FewRows shown = prospect.few.value_or(FewRows{&problem, problem.all_groups()});
  std::vector<std::pair<double, size_t>> order;
  for (size_t i = 0; i < starts.size(); ++i) {
    const Score score = shown.problem->score(with_effect(plain, prospect, starts[i]), shown.groups);
    order.emplace_back(
        score.valid ? -score.log_likelihood : std::numeric_limits<double>::infinity(), i);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::vector<double>> best;
  for (size_t i = 0; i < std::min(kMostCountsFitted, order.size()); ++i)
    best.push_back(starts[order[i].second]);
  return best;
}

// Fits from each start in turn and keeps the best; later starts only where the first may have
// been unlucky.
std::optional<Fitted> fit_from_starts(const Problem& problem, const Grown& base,
                                      const Prospect& prospect) {
  const auto& effect = prospect.effect;
  const std::vector<size_t>& open = prospect.free;
  std::vector<std::vector<double>> starts = prospect.starts;
  for (auto& start : starts) {
    for (size_t i = 0; i < std::min(start.size(), effect->parameters.size()); ++i) {
      const bool fitted = std::find(open.begin(), open.end(), i) != open.end();
      // What stays of a lens that can be any stays where the lens before it had it.
      if (!fitted && !effect->parameters[i].integer && !effects::is_any_lens(*effect))
        start[i] = effect->parameters[i].neutral;
    }
  }
  const bool counts = has_counts(*effect);
  if (counts && starts.size() > 1) starts = best_counts(problem, base, prospect, starts);
  std::optional<Fitted> best;
  for (const auto& values : starts) {
    const Model start = with_effect(base.assessment.model, prospect, values);
    std::vector<Unknown> unknowns;
    for (const Unknown& unknown : base.assessment.unknowns) {
      if (start.has(unknown.effect)) unknowns.push_back(unknown);
    }
    for (const size_t i : open) unknowns.push_back({effect->name, i});
    for (const auto& companion : prospect.companions) {
      for (size_t i = 0; i < companion->parameters.size(); ++i) {
        const Parameter& parameter = companion->parameters[i];
        if (!parameter.integer && !parameter.stated) unknowns.push_back({companion->name, i});
      }
    }
    Fitted fitted{.grown = {.added = base.added}};
    Grown& grown = fitted.grown;
    if (prospect.few) {
      Foretaste taste = foretaste(problem, *prospect.few, start, unknowns);
      grown.assessment = std::move(taste.assessment), fitted.most_ll = taste.most_ll;
    } else {
      grown.assessment = assess(problem, start, unknowns);
      fitted.most_ll = grown.assessment.total_ll;
    }
    std::erase_if(grown.added, [&](const std::string& name) { return !start.has(name); });
    add_once(grown.added, effect->name);
    for (const auto& companion : prospect.companions) add_once(grown.added, companion->name);
    if (!grown.assessment.valid) continue;
    if (!best || grown.assessment.total_ll > best->grown.assessment.total_ll)
      best = std::move(fitted);
    // Two starts are the two directions of a smooth effect, which meet at the same optimum.
    const Fit& fit = best->grown.assessment.fit;
    const bool stuck = std::find(fit.at_bound.begin(), fit.at_bound.end(), 1) != fit.at_bound.end();
    if (starts.size() == 2 && !counts && fit.converged && !stuck && effect->has_neutral) break;
  }
  return best;
}

// Cameras of which the model says something of their own.
std::set<std::string> cameras_named_in(const Model& model) {
  std::set<std::string> cameras;
  for (const effects::ModelEffect& effect : model.effects())
    cameras.insert(effects::camera_of(effect.definition->name));
  cameras.erase("");
  return cameras;
}

}  // namespace

bool has_place(const EffectDefinition& effect, Model model) {
  effects::remove_replaced(effect, model);
  model.add_neutral(std::make_shared<const EffectDefinition>(effect));
  return effects::conflict_in(model).empty();
}

bool has_draws(const Model& model) {
  return std::any_of(model.effects().begin(), model.effects().end(),
                     [](const auto& effect) { return effect.definition->draws_estimated; });
}

std::shared_ptr<const EffectDefinition> as_tried(
    const Problem& problem, const std::shared_ptr<const EffectDefinition>& effect) {
  if (problem.facts().set.kind != effects::kOutcomes || !effect->spread_only) return effect;
  EffectDefinition tried = *effect;
  tried.spread_only = false;
  return std::make_shared<const EffectDefinition>(std::move(tried));
}

EffectList absent_effects(const Problem& problem, const Model& model, const EffectList& own) {
  EffectList absent;
  const auto consider = [&](const std::shared_ptr<const EffectDefinition>& effect) {
    if (model.has(effect->name) || effect->parameters.empty()) return;
    const bool required = std::any_of(effect->parameters.begin(), effect->parameters.end(),
                                      [](const Parameter& p) { return p.required; });
    // Values that must be given can be found only where the record says where to begin.
    const auto& rule = effects::start_rule(*effect, problem.facts().set.kind);
    if (required && rule.search == effects::StartSearch::slope) return;
    if (!problem.acts(*effect)) return;
    if (effects::is_excluded(*effect, model)) return;
    absent.push_back(as_tried(problem, effect));
  };
  for (const auto& effect : effects::catalogue()) consider(effect);
  for (const auto& effect : own) consider(effect);
  for (const std::string& camera : cameras_named_in(model)) {
    for (const auto& effect : effects::catalogue()) {
      const auto of_one = effects::find_effect(effect->name + "@" + camera);
      if (of_one && has_place(*of_one, model)) consider(of_one);
    }
  }
  return absent;
}

std::optional<Evaluation> start_of_prospects(const Problem& problem, const Model& model,
                                             const Evaluation* near) {
  if (!problem.is_smooth(model) || problem.screening_groups()) return std::nullopt;
  Evaluation start = problem.evaluate(model, problem.all_groups(), near);
  if (!start.valid) return std::nullopt;
  // Each model beside it has slopes of its own.
  start.reusable.reset();
  return start;
}

std::optional<Prospect> prospect_of(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons, bool alone,
                                    const Evaluation* near, const FewRows* few) {
  const Model& model = base.assessment.model;
  if (effects::is_excluded(*effect, model)) return std::nullopt;
  if (effect->draws_estimated && base.assessment.error > kUseless) {
    reasons.push_back({effect->name, "", "the model misses too much for single draws to be told"});
    return std::nullopt;
  }
  Prospect prospect{.effect = effect};
  if (!alone) prospect.companions = effects::companions_of(*effect, model);
  prospect.starts = few ? few->problem->starts_on(few->groups, model, *effect, prospect.companions)
                        : problem.starts_together(model, *effect, prospect.companions);
  if (prospect.starts.empty()) return std::nullopt;
  const Model probe = with_effect(model, prospect, prospect.starts.front());
  std::vector<Unknown> others;
  for (const Unknown& unknown : base.assessment.unknowns) {
    if (probe.has(unknown.effect) && !probe.find(unknown.effect)->definition->spread_only)
      others.push_back(unknown);
  }
  if (has_counts(*effect)) {
    for (size_t i = 0; i < effect->parameters.size(); ++i) {
      const std::string why = problem.not_testable(probe, *effect, i);
      if (why.empty()) continue;
      reasons.push_back({effect->name, effect->parameters[i].name, why});
      return std::nullopt;
    }
  }
  // Draws that groups share are told by all of them together.
  if (few && problem.groups_are_independent(probe)) prospect.few = *few;
  const std::optional<Groups> screening =
      few ? std::optional(few->groups) : problem.screening_groups();
  const Groups groups = screening.value_or(problem.all_groups());
  const Problem& shown = few ? *few->problem : problem;
  LinearStep step;
  prospect.free = testable_parameters(shown, probe, others, *effect, groups, near, reasons, step);
  if (prospect.free.empty() && !has_counts(*effect)) return std::nullopt;
  if (screening && std::isfinite(step.expected_ll)) {
    // All groups are expected to gain as these do.
    const Score before = shown.score(model, groups);
    const double share = static_cast<double>(before.n) / static_cast<double>(count_used(problem));
    step.expected_ll =
        base.assessment.total_ll + (step.expected_ll - before.log_likelihood) / share;
  }
  prospect.step_to = step.to;
  // More starts (a phase's quarters): several valleys, of which the first says little.
  if (prospect.starts.size() > kMostStartsOfOneValley || has_counts(*effect)) return prospect;
  prospect.expected_ll = step.expected_ll;
  // Steps are short where a model misses little: where one ends, a fit does.
  const bool dear = shown.screening_groups().has_value();
  if (dear && base.assessment.error < kMisfit && prospect.companions.empty())
    prospect.end_of_step = std::move(step.to);
  return prospect;
}

std::optional<Candidate> fit_prospect(const Problem& problem, const Grown& base,
                                      const Prospect& prospect, std::vector<NotTestable>& reasons) {
  auto fitted = fit_from_starts(problem, base, prospect);
  if (!fitted) {
    reasons.push_back(
        {prospect.effect->name, "", "with it the model predicts no image for some observations"});
    return std::nullopt;
  }
  // Few groups may not reach where all of them forbid it.
  const std::string refused =
      prospect.few ? "" : problem.no_result_because(fitted->grown.assessment.model);
  if (!refused.empty() && problem.no_result_because(base.assessment.model).empty()) {
    reasons.push_back({prospect.effect->name, "", refused});
    return std::nullopt;
  }
  return Candidate{.effect = prospect.effect,
                   .grown = std::move(fitted->grown),
                   .companions = prospect.companions,
                   .free = prospect.free,
                   .of_few = prospect.few.has_value(),
                   .most_ll = fitted->most_ll};
}

std::optional<Candidate> try_effect(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons) {
  const auto prospect = prospect_of(problem, base, effect, reasons);
  return prospect ? fit_prospect(problem, base, *prospect, reasons) : std::nullopt;
}

Grown named_by_camera(const Problem& problem, Grown grown) {
  const std::set<std::string> cameras = cameras_named_in(problem.given());
  // What the given model says of all cameras may be that of one that it does not name.
  const bool all_named = std::all_of(
      problem.given().effects().begin(), problem.given().effects().end(), [&](const auto& effect) {
        const std::string& name = effect.definition->name;
        return !effects::camera_of(name).empty() || cameras.empty() ||
               !effects::find_effect(name + "@" + *cameras.begin());
      });
  if (cameras.size() < 2 || !all_named) return grown;
  Model& model = grown.assessment.model;
  bool changed = false;
  for (std::string& name : grown.added) {
    std::vector<std::string> acts_in;
    for (const std::string& camera : cameras) {
      if (effects::camera_of(name).empty() && !model.has(name + "@" + camera))
        acts_in.push_back(name + "@" + camera);
    }
    const auto own = acts_in.size() == 1 ? effects::find_effect(acts_in.front()) : nullptr;
    if (!own) continue;
    std::vector<ParameterValue> values = model.find(name)->parameters;
    model.remove(name);
    model.set(own, std::move(values));
    for (Unknown& unknown : grown.assessment.unknowns) {
      if (unknown.effect == name) unknown.effect = own->name;
    }
    name = own->name, changed = true;
  }
  if (changed) grown.assessment = assess(problem, model, grown.assessment.unknowns);
  return grown;
}

}  // namespace seam::measurement
