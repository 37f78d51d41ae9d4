#include "measurement/candidates.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/registry.h"
#include "measurement/regression.h"

namespace seam::measurement {
namespace {

using effects::Parameter;
using effects::ParameterValue;

bool is_radial(const std::string& name) {
  return name == "radial_distortion" || name == "radial_polynomial";
}

bool has_counts(const EffectDefinition& effect) {
  return std::any_of(effect.parameters.begin(), effect.parameters.end(),
                     [](const Parameter& p) { return p.integer; });
}

// The model with the effect at these values; replacements push out what they replace.
Model with_effect(Model model, const std::shared_ptr<const EffectDefinition>& effect,
                  const std::vector<double>& values) {
  if (effect->name == "fisheye") {
    for (const char* name : {"radial_distortion", "radial_polynomial"}) model.remove(name);
  }
  std::vector<ParameterValue> parameters;
  for (size_t i = 0; i < values.size(); ++i) parameters.push_back({.value = values[i]});
  model.set(effect, std::move(parameters));
  return model;
}

double column_dot(const std::vector<double>& a, const std::vector<double>& b) {
  return Eigen::Map<const Eigen::VectorXd>(a.data(), a.size())
      .dot(Eigen::Map<const Eigen::VectorXd>(b.data(), b.size()));
}

// Which of the effect's parameters these groups can say anything of, beyond what the parameters that
// are refitted anyway absorb; and, where the problem is smooth, what one step would reach on them.
std::vector<size_t> testable_parameters(const Problem& problem, const Model& model,
                                        const std::vector<Unknown>& others,
                                        const EffectDefinition& effect, const Groups& groups,
                                        std::vector<NotTestable>& reasons, double& expected_ll) {
  std::vector<size_t> open;
  for (size_t i = 0; i < effect.parameters.size(); ++i) {
    if (effect.parameters[i].integer) continue;
    const std::string why = problem.not_testable(model, effect, i);
    if (why.empty()) {
      open.push_back(i);
    } else {
      reasons.push_back({effect.name, effect.parameters[i].name, why});
    }
  }
  if (effect.spread_only || open.empty() || !effect.has_neutral) return open;
  std::vector<Unknown> unknowns = others;
  for (const size_t i : open) unknowns.push_back({effect.name, i});
  const Evaluation here = problem.evaluate(model, groups);
  if (!here.valid) return open;
  auto columns = problem.jacobian(model, unknowns, groups, here);
  // Gram-Schmidt: what is left of each column is its leverage.
  std::vector<size_t> testable;
  std::vector<std::vector<double>> basis;
  double gain = 0;
  for (size_t k = 0; k < unknowns.size(); ++k) {
    std::vector<double>& column = columns[k];
    const double before = std::sqrt(column_dot(column, column));
    for (int twice = 0; twice < 2; ++twice) {
      for (const auto& direction : basis) {
        const double along = column_dot(direction, column);
        for (size_t i = 0; i < column.size(); ++i) column[i] -= along * direction[i];
      }
    }
    const double after = std::sqrt(column_dot(column, column));
    const bool candidate = k >= others.size();
    const size_t parameter = unknowns[k].parameter;
    const double width =
        candidate ? effect.parameters[parameter].max - effect.parameters[parameter].min : 0;
    if (before <= 0 || after < 1e-5 * before) {
      if (candidate) {
        reasons.push_back({effect.name, effect.parameters[parameter].name,
                           before <= 0 ? "it does not change the prediction of these data"
                                       : "other free parameters absorb it"});
      }
      continue;
    }
    if (candidate && after * width < 2) {
      reasons.push_back({effect.name, effect.parameters[parameter].name,
                         "these data could not see it at any size in its bounds"});
      continue;
    }
    for (double& value : column) value /= after;
    const double along = column_dot(column, here.whitened);
    gain += 0.5 * along * along;
    basis.push_back(column);
    if (candidate) testable.push_back(parameter);
  }
  if (problem.is_smooth()) expected_ll = score_of(problem, here).log_likelihood + gain;
  return testable;
}

// A model whose refitted parameters are back at the values that they were given with.
Model as_given(Model model, const std::vector<Unknown>& refitted, const Model& given) {
  for (const Unknown& unknown : refitted) {
    const effects::ModelEffect* effect = given.find(unknown.effect);
    if (effect != nullptr) model.set_value(unknown.effect, unknown.parameter, effect->parameters[unknown.parameter].value);
  }
  return model;
}

// Fits from each start in turn and keeps the best; later starts only where the first may have
// been unlucky. An effect that replaces another is far from what was fitted without it, so the fit
// starts from the given values as well.
std::optional<Grown> fit_from_starts(const Problem& problem, const Grown& base,
                                     const std::shared_ptr<const EffectDefinition>& effect,
                                     const std::vector<size_t>& open,
                                     std::vector<std::vector<double>> starts) {
  for (auto& start : starts) {
    for (size_t i = 0; i < start.size(); ++i) {
      const bool fitted = std::find(open.begin(), open.end(), i) != open.end();
      if (!fitted && !effect->parameters[i].integer) start[i] = effect->parameters[i].neutral;
    }
  }
  const bool counts = has_counts(*effect);
  if (counts && starts.size() > 1) {  // Counts are not fitted but tried: the best two go on.
    std::vector<std::pair<double, size_t>> order;
    // Effects of spread do not change which of them fits the mean, and would cost most of the time.
    Model plain = base.assessment.model;
    for (const effects::ModelEffect& other : base.assessment.model.effects()) {
      if (other.definition->spread_only) plain.remove(other.definition->name);
    }
    for (size_t i = 0; i < starts.size(); ++i) {
      const Score score =
          problem.score(with_effect(plain, effect, starts[i]), problem.all_groups());
      order.emplace_back(
          score.valid ? -score.log_likelihood : std::numeric_limits<double>::infinity(), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::vector<double>> best;
    for (size_t i = 0; i < std::min<size_t>(2, order.size()); ++i)
      best.push_back(starts[order[i].second]);
    starts = best;
  }
  std::vector<Model> bases = {base.assessment.model};
  if (!effect->has_neutral) bases.push_back(as_given(bases[0], base.assessment.unknowns, problem.given()));
  std::optional<Grown> best;
  for (size_t s = 0; s < starts.size() * bases.size(); ++s) {
    const Model start = with_effect(bases[s / starts.size()], effect, starts[s % starts.size()]);
    std::vector<Unknown> unknowns;
    for (const Unknown& unknown : base.assessment.unknowns) {
      if (start.has(unknown.effect)) unknowns.push_back(unknown);
    }
    for (const size_t i : open) unknowns.push_back({effect->name, i});
    Grown grown{.added = base.added, .assessment = assess(problem, start, unknowns)};
    std::erase_if(grown.added, [&](const std::string& name) { return !start.has(name); });
    grown.added.push_back(effect->name);
    if (!grown.assessment.valid) continue;
    if (!best || grown.assessment.total_ll > best->assessment.total_ll) best = std::move(grown);
    // Two starts are the two directions of a smooth effect, which meet at the same optimum.
    const bool stuck =
        std::find(best->assessment.fit.at_bound.begin(), best->assessment.fit.at_bound.end(), 1) !=
        best->assessment.fit.at_bound.end();
    if (starts.size() == 2 && !counts && best->assessment.fit.converged && !stuck &&
        effect->has_neutral)
      break;
  }
  return best;
}

// Fitted parameters of an effect that are clearly away from neutral.
size_t clear_parameters(const Grown& grown, const std::string& name) {
  const effects::ModelEffect* effect = grown.assessment.model.find(name);
  size_t clear = 0;
  for (size_t k = 0; k < grown.assessment.unknowns.size(); ++k) {
    const Unknown& unknown = grown.assessment.unknowns[k];
    if (unknown.effect != name) continue;
    const double away = std::abs(grown.assessment.fit.value[k] -
                                 effect->definition->parameters[unknown.parameter].neutral);
    clear += away > 2.5 * grown.assessment.fit.sigma[k];
  }
  return clear;
}

size_t needed_parameters(const Grown& grown) {
  size_t needed = 0;
  for (const std::string& name : grown.added) needed += std::max<size_t>(1, clear_parameters(grown, name));
  return needed;
}

size_t fitted_parameters(const Grown& grown) {
  size_t count = 0;
  for (const Unknown& unknown : grown.assessment.unknowns) {
    count += std::find(grown.added.begin(), grown.added.end(), unknown.effect) != grown.added.end();
  }
  return count;
}

bool bounded_at_neutral(const EffectDefinition& effect) {
  return std::any_of(effect.parameters.begin(), effect.parameters.end(),
                     [](const Parameter& p) { return p.min >= p.neutral || p.max <= p.neutral; });
}

}  // namespace

double gain_over_scatter(const Score& before, const Score& after) {
  double count = 0, sum = 0, sum2 = 0;
  for (size_t g = 0; g < after.by_group.size(); ++g) {
    if (g >= before.by_group.size() || (after.by_group[g] == 0 && before.by_group[g] == 0))
      continue;
    const double gain = after.by_group[g] - before.by_group[g];
    ++count, sum += gain, sum2 += gain * gain;
  }
  if (count < 3) return 0;
  const double variance = (sum2 - sum * sum / count) / (count - 1);
  return sum / std::sqrt(std::max(variance * count, 1e-300));
}

EffectList absent_effects(const Problem& problem, const Model& model, const EffectList& own) {
  EffectList absent;
  const auto consider = [&](const std::shared_ptr<const EffectDefinition>& effect) {
    if (model.has(effect->name) || effect->parameters.empty()) return;
    const bool required = std::any_of(effect->parameters.begin(), effect->parameters.end(),
                                      [](const Parameter& p) { return p.required; });
    if (required || !problem.acts(*effect)) return;
    if (is_radial(effect->name) && model.has("fisheye")) return;
    absent.push_back(effect);
  };
  for (const auto& effect : effects::catalogue()) consider(effect);
  for (const auto& effect : own) consider(effect);
  return absent;
}

double tie_width(double error) {
  return 4.6 * std::max(1.0, error * error);
}

double merit_of(const Problem& problem, const Grown& grown) {
  const double size = std::log(static_cast<double>(std::max<size_t>(count_used(problem), 3)));
  const size_t needed = needed_parameters(grown);
  const size_t fitted = std::max(fitted_parameters(grown), needed);
  return grown.assessment.total_ll - 0.5 * size * static_cast<double>(needed) -
         static_cast<double>(fitted - needed);
}

std::optional<Prospect> prospect_of(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons) {
  if (is_radial(effect->name) && base.assessment.model.has("fisheye")) return std::nullopt;
  Prospect prospect{.effect = effect, .starts = problem.starts(base.assessment.model, *effect)};
  if (prospect.starts.empty()) return std::nullopt;
  const Model probe = with_effect(base.assessment.model, effect, prospect.starts.front());
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
  const std::optional<Groups> screening = problem.screening_groups();
  const Groups groups = screening.value_or(problem.all_groups());
  double expected = prospect.expected_ll;
  prospect.free = testable_parameters(problem, probe, others, *effect, groups, reasons, expected);
  if (prospect.free.empty() && !has_counts(*effect)) return std::nullopt;
  if (screening && std::isfinite(expected)) {
    // All groups are expected to gain as these do.
    const Score before = problem.score(base.assessment.model, groups);
    const double share = static_cast<double>(before.n) / static_cast<double>(count_used(problem));
    expected = base.assessment.total_ll + (expected - before.log_likelihood) / share;
  }
  // More than four starts (a phase's quarters): several valleys, of which the first says little.
  if (prospect.starts.size() <= 4 && !has_counts(*effect)) prospect.expected_ll = expected;
  return prospect;
}

std::optional<Candidate> fit_prospect(const Problem& problem, const Grown& base,
                                      const Prospect& prospect, std::vector<NotTestable>& reasons) {
  auto grown = fit_from_starts(problem, base, prospect.effect, prospect.free, prospect.starts);
  if (!grown) {
    reasons.push_back(
        {prospect.effect->name, "", "with it the model predicts no image for some observations"});
    return std::nullopt;
  }
  return Candidate{.effect = prospect.effect, .grown = std::move(*grown), .free = prospect.free};
}

std::optional<Candidate> try_effect(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons) {
  const auto prospect = prospect_of(problem, base, effect, reasons);
  return prospect ? fit_prospect(problem, base, *prospect, reasons) : std::nullopt;
}

// What the model loses without the effect, all else as it is: at least what the effect gained, or else some of that gain
// is the base's, whose fit had stopped early.
double loss_without(const Problem& problem, const Candidate& candidate) {
  const Model& with = candidate.grown.assessment.model;
  Model without = with;
  without.remove(candidate.effect->name);
  const Groups all = problem.all_groups();
  const Score here = problem.score(with, all), there = problem.score(without, all);
  return here.valid && there.valid ? here.log_likelihood - there.log_likelihood : std::numeric_limits<double>::infinity();
}

void judge(const Problem& problem, const Grown& base, double looks, Candidate& candidate) {
  const Assessment& before = base.assessment;
  const Assessment& after = candidate.grown.assessment;
  candidate.gain_ll = after.held_ll() - before.held_ll();
  candidate.total_gain_ll = after.total_ll - before.total_ll;
  candidate.held_z = gain_over_scatter(before.held, after.held);
  candidate.at_bound = false;
  for (size_t k = 0; k < after.unknowns.size(); ++k) {
    if (after.unknowns[k].effect == candidate.effect->name && after.fit.at_bound[k])
      candidate.at_bound = true;
  }
  looks *= problem.looks(before.model, *candidate.effect);
  // Where the model misses more than the noise, likelihood ratios are worth less in proportion.
  const double misfit = std::max(1.0, after.error * after.error);
  const double ratio = 2 * candidate.total_gain_ll / misfit;
  const double freedom = static_cast<double>(std::max<size_t>(1, candidate.free.size()));
  const double tail = chi2_tail(ratio, freedom);
  candidate.p_value = tail <= 1e-299 ? 1e-300 : std::min(1.0, tail * looks);
  // One parameter gains as much as it stands clear of neutral; a gain without is the base's, whose fit had stopped early.
  const bool clear = has_counts(*candidate.effect) || candidate.effect->spread_only ||
                     clear_parameters(candidate.grown, candidate.effect->name) > 0;
  // Beyond the noise a likelihood says little: held-out groups must agree that they gain, and some value be clear.
  const bool agreed = after.error <= kMisfit ? clear || candidate.free.size() > 1 : clear && candidate.held_z > 1;
  // Held-out groups must agree. Where all groups together leave no doubt, they may be unlucky: by as much as noise makes them
  // in one of ten cases at five standard errors, or by what their scatter does in one of ten.
  const bool beyond_doubt = candidate.p_value < 0.01 * kCandidateAlarm && after.error < kMisfit;
  const bool held_out_agree =
      candidate.gain_ll > 0 || (beyond_doubt && (candidate.gain_ll > -2 || candidate.held_z > -1.3));
  candidate.significant = candidate.p_value < kCandidateAlarm && agreed && held_out_agree &&
                          problem.is_visible(before.model, after.model);
  if (candidate.significant && candidate.effect->has_neutral && !has_counts(*candidate.effect))
    candidate.significant = loss_without(problem, candidate) > 0.5 * candidate.total_gain_ll;
  candidate.merit = merit_of(problem, candidate.grown);
}

bool clearly_helps(const Candidate& candidate) {
  constexpr double kClear = 4;  // Standard errors.
  return candidate.significant && !candidate.effect->spread_only && candidate.held_z > kClear;
}

void rank_candidates(std::vector<Candidate>& candidates) {
  // While nothing explains the set by far, training groups can be fitted by what is wrong elsewhere.
  const bool far = std::all_of(candidates.begin(), candidates.end(), [](const Candidate& c) {
    return c.grown.assessment.error > kUseless;
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Candidate& a, const Candidate& b) {
                     if (a.significant != b.significant) return a.significant;
                     return far ? a.gain_ll > b.gain_ll : a.merit > b.merit;
                   });
  if (candidates.empty() || !candidates.front().significant) return;
  // Among those as good as the best: fewer parameters, then no bound at neutral.
  const double width = tie_width(candidates.front().grown.assessment.error);
  const double best_merit = candidates.front().merit;
  const double best_total = candidates.front().total_gain_ll;
  const auto tied = [&](const Candidate& c) {
    return c.significant && best_merit - c.merit < width &&
           std::abs(best_total - c.total_gain_ll) < width;
  };
  const auto end = std::stable_partition(candidates.begin(), candidates.end(), tied);
  std::stable_sort(candidates.begin(), end, [](const Candidate& a, const Candidate& b) {
    if (a.free.size() != b.free.size() && std::abs(a.total_gain_ll - b.total_gain_ll) < 2)
      return a.free.size() < b.free.size();
    if (std::abs(a.total_gain_ll - b.total_gain_ll) < 0.5)
      return !bounded_at_neutral(*a.effect) && bounded_at_neutral(*b.effect);
    return false;
  });
  for (Candidate& candidate : candidates) {
    if (!candidate.significant) continue;
    const double own = tie_width(candidate.grown.assessment.error);
    for (const Candidate& other : candidates) {
      if (&other == &candidate || !other.significant) continue;
      if (std::abs(other.total_gain_ll - candidate.total_gain_ll) < own &&
          candidate.indistinguishable_from.size() < 3) {
        candidate.indistinguishable_from.push_back(other.effect->name);
      }
    }
  }
}

namespace {

// Marks the prospects worth a fit: those that the score test calls significant or nearly so, and of
// these the best few. What a step of Gauss and Newton cannot judge is always fitted.
std::vector<char> worth_fitting(const Problem& problem, const Grown& base,
                                const std::vector<std::optional<Prospect>>& prospects) {
  constexpr size_t kMost = 6;
  constexpr double kMargin = 1.5;  // Gains may exceed the step's by this much.
  const double n = static_cast<double>(std::max<size_t>(1, count_used(problem)));
  std::vector<char> worth(prospects.size(), 0);
  std::vector<std::pair<double, size_t>> ranked;
  for (size_t i = 0; i < prospects.size(); ++i) {
    if (!prospects[i]) continue;
    if (!std::isfinite(prospects[i]->expected_ll)) {
      worth[i] = 1;
      continue;
    }
    const double gain = prospects[i]->expected_ll - base.assessment.total_ll;
    const double error = base.assessment.error;
    const double misfit = std::max(1.0, error * error - 2 * gain / n);
    const double freedom = static_cast<double>(std::max<size_t>(1, prospects[i]->free.size()));
    const double tail = chi2_tail(kMargin * 2 * std::max(gain, 0.0) / misfit, freedom);
    if (tail * static_cast<double>(prospects.size()) < 0.5)
      ranked.emplace_back(-prospects[i]->expected_ll, i);
  }
  std::sort(ranked.begin(), ranked.end());
  if (ranked.size() > kMost) ranked.resize(kMost);
  for (const auto& [order, i] : ranked) worth[i] = 1;
  return worth;
}

}  // namespace

Looks look_at(const Problem& problem, const Grown& base, const EffectList& effects,
              bool promising_only) {
  std::vector<std::optional<Prospect>> prospects(effects.size());
  std::vector<std::vector<NotTestable>> reasons(effects.size());
  promising_only = problem.is_smooth() && (promising_only || problem.screening_groups());
  // A spread was taken since no effect of the mean helped: where a misfit stays nevertheless, only
  // another spread can help.
  const bool spread_taken = std::any_of(
      base.added.begin(), base.added.end(),
      [&](const auto& name) { return base.assessment.model.find(name)->definition->spread_only; });
  const bool spreads_only = promising_only && spread_taken && base.assessment.error > kMisfit;
  parallel_for(effects.size(), [&](size_t i) {
    if (spreads_only && !effects[i]->spread_only) return;
    prospects[i] = prospect_of(problem, base, effects[i], reasons[i]);
  });
  Looks looks;
  for (const auto& prospect : prospects) looks.tried += prospect.has_value();
  std::vector<char> worth(effects.size(), 1);
  if (promising_only) worth = worth_fitting(problem, base, prospects);
  std::vector<std::optional<Candidate>> found(effects.size());
  const auto fit = [&](const auto& chosen) {
    parallel_for(effects.size(), [&](size_t i) {
      if (!prospects[i] || !worth[i] || !chosen(*effects[i])) return;
      found[i] = fit_prospect(problem, base, *prospects[i], reasons[i]);
      if (found[i]) judge(problem, base, looks.tried, *found[i]);
    });
  };
  fit([](const EffectDefinition& effect) { return !effect.spread_only; });
  const bool clear =
      std::any_of(found.begin(), found.end(), [](const auto& c) { return c && clearly_helps(*c); });
  if (!promising_only || !clear)
    fit([](const EffectDefinition& effect) { return effect.spread_only; });
  for (size_t i = 0; i < effects.size(); ++i) {
    looks.not_testable.insert(looks.not_testable.end(), reasons[i].begin(), reasons[i].end());
    if (found[i]) looks.candidates.push_back(std::move(*found[i]));
  }
  rank_candidates(looks.candidates);
  return looks;
}

}  // namespace seam::measurement
