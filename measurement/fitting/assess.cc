#include "measurement/fitting/assess.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/leave_out.h"
#include "measurement/numerics/parallel_for.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

void pool(Score& into, const Score& part) {
  if (into.by_group.empty()) {
    into = part;
    return;
  }
  into.chi2 += part.chi2;
  into.n += part.n;
  into.nuisances += part.nuisances;
  into.log_likelihood += part.log_likelihood;
  into.valid = into.valid && part.valid;
  for (size_t g = 0; g < part.by_group.size(); ++g) into.by_group[g] += part.by_group[g];
  for (size_t b = 0; b < part.by_block.size(); ++b) into.by_block[b] += part.by_block[b];
  for (size_t c = 0; c < part.native_sum2.size(); ++c) {
    into.native_sum2[c] += part.native_sum2[c];
    into.native_count[c] += part.native_count[c];
    into.native[c] =
        into.native_count[c]
            ? std::sqrt(into.native_sum2[c] / static_cast<double>(into.native_count[c]))
            : 0;
  }
}

}  // namespace

std::vector<Unknown> refitted_unknowns(const Model& model) {
  std::vector<Unknown> unknowns;
  for (const effects::ModelEffect& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      if (effect.parameters[i].refitted() && !effect.definition->parameters[i].integer) {
        unknowns.push_back({effect.definition->name, i});
      }
    }
  }
  return unknowns;
}

namespace {

Fit fit_on(const Problem& problem, const Groups& groups, const Model& start,
           const std::vector<Unknown>& unknowns) {
  if (unknowns.empty()) return Fit{.model = start, .converged = true};
  Fit fit = problem.fit(start, unknowns, groups);
  for (size_t k = 0; k < unknowns.size(); ++k) {
    const effects::ModelEffect& effect = *fit.model.find(unknowns[k].effect);
    const double resolution = effect.definition->parameters[unknowns[k].parameter].resolution;
    fit.sigma[k] = std::sqrt(fit.sigma[k] * fit.sigma[k] + resolution * resolution / 12);
  }
  return fit;
}

// Whether the one group there is is cut into blocks that are held out in turn. Where predictions
// are dear, as of images, a group alone is both trained on and held out.
bool cuts_one_group(const Problem& problem) {
  return problem.facts().groups.size() == 1 && !problem.blocks().empty() &&
         !problem.screening_groups();
}

// On each group, or block, under a fit to the others.
Score held_in_turn(const Problem& problem, const Fit& whole, const std::vector<Unknown>& unknowns) {
  Score held;
  if (unknowns.empty() && problem.facts().groups.size() == 1)
    return problem.score(whole.model, problem.all_groups());
  // Where groups share what is estimated of them all, a step from the fit to all says too little.
  if (problem.groups_are_independent(whole.model)) {
    for (const Score& part : scores_held_out(problem, whole, unknowns)) pool(held, part);
    if (!held.by_group.empty()) return held;
  }
  // Without residual vectors no part of it can be left out.
  if (problem.facts().groups.size() == 1)
    return problem.score_held_out(whole.model, problem.all_groups());
  for (const Groups& fold : problem.folds()) {
    const Fit fit = fit_on(problem, complement(fold), whole.model, unknowns);
    pool(held, problem.score_held_out(fit.model, fold));
  }
  return held;
}

}  // namespace

Assessment assess_fitted_to(const Problem& problem, const Problem& shown, const Groups& groups,
                            const Model& model, const std::vector<Unknown>& unknowns) {
  Assessment result{.model = model, .unknowns = unknowns};
  result.fit = fit_on(shown, groups, model, unknowns);
  result.model = result.fit.model;
  const bool one_fold = problem.folds().size() == 1;
  // One group alone is both trained on and held out, and counts once.
  const bool sum =
      one_fold && problem.groups_are_independent(result.model) && problem.facts().groups.size() > 1;
  Score rest;
  parallel_for(2, [&](size_t which) {
    if (which == 0) {
      const Groups held = one_fold ? problem.folds()[0] : problem.all_groups();
      result.held = problem.score_held_out(result.model, held);
    } else {
      rest = problem.score(result.model, sum ? problem.training_groups() : problem.all_groups());
    }
  });
  result.total_ll = rest.log_likelihood + (sum ? result.held.log_likelihood : 0);
  result.valid = result.held.valid && rest.valid && std::isfinite(result.total_ll);
  result.error = result.held.error();
  return result;
}

namespace {

// Goes on to the values that all groups tell; what training groups say of the others stays.
// Spreads, which are dear to fit along a path, have no such directions.
void fit_to_all(const Problem& problem, Assessment& assessment) {
  const bool spreads = std::any_of(
      assessment.unknowns.begin(), assessment.unknowns.end(), [&](const Unknown& unknown) {
        return assessment.model.find(unknown.effect)->definition->spread_only;
      });
  if (spreads) return;
  const Groups all = problem.all_groups();
  const Fit fit = fit_on(problem, all, assessment.model, assessment.unknowns);
  const Score score = problem.score(fit.model, all);
  if (!score.valid || !(score.log_likelihood >= assessment.total_ll)) return;
  assessment.fit = fit, assessment.model = fit.model, assessment.total_ll = score.log_likelihood;
}

// Whether what a fit to training groups loses on the others may decide between two explanations:
// about half a unit for each parameter and held-out residual a training one, by chance. Half of the
// width within which two count as equal.
bool chance_decides(const Problem& problem, const Assessment& assessment) {
  constexpr double kMayDecide = 2.3;
  const auto all = static_cast<double>(count_used(problem)),
             held = static_cast<double>(assessment.held.n);
  return all > held &&
         0.5 * static_cast<double>(assessment.unknowns.size()) * held > kMayDecide * (all - held);
}

}  // namespace

Assessment assess(const Problem& problem, const Model& model,
                  const std::vector<Unknown>& unknowns) {
  if (problem.folds().size() == 1 && !cuts_one_group(problem)) {
    Assessment result =
        assess_fitted_to(problem, problem, problem.training_groups(), model, unknowns);
    // Far from the noise a few units of likelihood decide nothing.
    constexpr double kNearNoise = 1.5;
    if (result.error < kNearNoise &&
        (!problem.training_stands_for_all() || chance_decides(problem, result)))
      fit_to_all(problem, result);
    return result;
  }
  Assessment result{.model = model, .unknowns = unknowns};
  const Groups all = problem.all_groups();
  result.fit = fit_on(problem, all, model, unknowns);
  result.model = result.fit.model;
  const Score whole = problem.score(result.model, all);
  result.total_ll = whole.log_likelihood;
  result.held = held_in_turn(problem, result.fit, unknowns);
  result.valid = whole.valid && result.held.valid && std::isfinite(result.total_ll);
  result.error = result.held.error();
  return result;
}

void add_to_key(const std::string& text, std::vector<double>& key) {
  key.push_back(static_cast<double>(std::hash<std::string>{}(text) >> 12));
}

std::vector<double> key_of(const Problem& problem, const Assessment& assessment) {
  std::vector<double> key = {static_cast<double>(problem.times_marked()), assessment.total_ll};
  for (const Unknown& unknown : assessment.unknowns)
    add_to_key(unknown.effect + "." + std::to_string(unknown.parameter), key);
  for (const effects::ModelEffect& effect : assessment.model.effects()) {
    add_to_key(effect.definition->name + "\n" + effect.definition->source, key);
    for (const double value : effect.values()) key.push_back(value);
  }
  return key;
}

void check_enough(const Problem& problem, const Assessment& assessment) {
  const Score& held = assessment.held;
  const auto fail = [&](const std::string& what, int64_t residuals, int64_t unknowns) {
    throw InputError(
        fmt::format("{}: {} have {} residuals for {} unknowns (poses or starts of their own{}): "
                    "too few to tell "
                    "a model by",
                    problem.facts().file, what, residuals, unknowns,
                    what == "all groups" ? ", parameters that are fitted" : ""));
  };
  if (held.n <= held.nuisances) fail("the held-out groups", held.n, held.nuisances);
  if (held.nuisances == 0) return;
  const Score all = problem.score(assessment.model, problem.all_groups());
  const int64_t unknowns = all.nuisances + static_cast<int64_t>(assessment.unknowns.size());
  if (all.n <= unknowns) fail("all groups", all.n, unknowns);
}

Assessment assess_fixed(const Problem& problem, const Model& model) {
  return assess(problem, model, {});
}

void write_sigmas(Model& model, const std::vector<Unknown>& unknowns, const Fit& fit) {
  for (size_t i = 0; i < unknowns.size(); ++i) {
    const effects::ModelEffect* effect = model.find(unknowns[i].effect);
    effects::ModelEffect changed = *effect;
    effects::ParameterValue value = changed.parameters[unknowns[i].parameter];
    if (std::isfinite(fit.sigma[i])) value.sigma = fit.sigma[i];
    std::vector<effects::ParameterValue> values = changed.parameters;
    values[unknowns[i].parameter] = value;
    model.set(changed.definition, std::move(values));
  }
}

size_t count_used(const Problem& problem) {
  size_t count = 0;
  for (size_t i = 0; i < problem.facts().scalars(); ++i) count += !problem.left_out(i);
  return count;
}

}  // namespace seam::measurement
