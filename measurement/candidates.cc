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

// Which of the effect's parameters the data can say anything of, beyond what the parameters that
// are refitted anyway absorb.
std::vector<size_t> testable_parameters(const Problem& problem, const Model& model,
                                        const std::vector<Unknown>& others,
                                        const EffectDefinition& effect,
                                        std::vector<NotTestable>& reasons) {
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
  const Groups all = problem.all_groups();
  const Evaluation here = problem.evaluate(model, all);
  if (!here.valid) return open;
  auto columns = problem.jacobian(model, unknowns, all, here);
  // Gram-Schmidt: what is left of each column is its leverage.
  std::vector<size_t> testable;
  std::vector<std::vector<double>> basis;
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
    basis.push_back(column);
    if (candidate) testable.push_back(parameter);
  }
  return testable;
}

// Fits from each start in turn and keeps the best; later starts only where the first may have
// been unlucky.
std::optional<Grown> fit_from_starts(const Problem& problem, const Grown& base,
                                     const std::shared_ptr<const EffectDefinition>& effect,
                                     const std::vector<size_t>& open) {
  std::vector<std::vector<double>> starts = problem.starts(base.assessment.model, *effect);
  for (auto& start : starts) {
    for (size_t i = 0; i < start.size(); ++i) {
      const bool fitted = std::find(open.begin(), open.end(), i) != open.end();
      if (!fitted && !effect->parameters[i].integer) start[i] = effect->parameters[i].neutral;
    }
  }
  const bool counts = std::any_of(effect->parameters.begin(), effect->parameters.end(),
                                  [](const Parameter& p) { return p.integer; });
  if (counts && starts.size() > 1) {  // Counts are not fitted but tried: the best two go on.
    std::vector<std::pair<double, size_t>> order;
    for (size_t i = 0; i < starts.size(); ++i) {
      const Score score = problem.score(with_effect(base.assessment.model, effect, starts[i]),
                                        problem.all_groups());
      order.emplace_back(
          score.valid ? -score.log_likelihood : std::numeric_limits<double>::infinity(), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<std::vector<double>> best;
    for (size_t i = 0; i < std::min<size_t>(2, order.size()); ++i)
      best.push_back(starts[order[i].second]);
    starts = best;
  }
  std::optional<Grown> best;
  for (size_t s = 0; s < starts.size(); ++s) {
    const Model start = with_effect(base.assessment.model, effect, starts[s]);
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

size_t needed_parameters(const Grown& grown) {
  size_t needed = 0;
  for (const std::string& name : grown.added) {
    const effects::ModelEffect* effect = grown.assessment.model.find(name);
    size_t own = 0;
    for (size_t k = 0; k < grown.assessment.unknowns.size(); ++k) {
      const Unknown& unknown = grown.assessment.unknowns[k];
      if (unknown.effect != name) continue;
      const double away = std::abs(grown.assessment.fit.value[k] -
                                   effect->definition->parameters[unknown.parameter].neutral);
      own += away > 2.5 * grown.assessment.fit.sigma[k];
    }
    needed += std::max<size_t>(1, own);
  }
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

std::optional<Candidate> try_effect(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons) {
  if (is_radial(effect->name) && base.assessment.model.has("fisheye")) return std::nullopt;
  const std::vector<std::vector<double>> starts = problem.starts(base.assessment.model, *effect);
  if (starts.empty()) return std::nullopt;
  const Model probe = with_effect(base.assessment.model, effect, starts.front());
  std::vector<Unknown> others;
  for (const Unknown& unknown : base.assessment.unknowns) {
    if (probe.has(unknown.effect) && !probe.find(unknown.effect)->definition->spread_only)
      others.push_back(unknown);
  }
  Candidate candidate{.effect = effect};
  const bool counts = std::any_of(effect->parameters.begin(), effect->parameters.end(),
                                  [](const Parameter& p) { return p.integer; });
  if (counts) {
    for (size_t i = 0; i < effect->parameters.size(); ++i) {
      const std::string why = problem.not_testable(probe, *effect, i);
      if (why.empty()) continue;
      reasons.push_back({effect->name, effect->parameters[i].name, why});
      return std::nullopt;
    }
  }
  candidate.free = testable_parameters(problem, probe, others, *effect, reasons);
  if (candidate.free.empty() && !counts) return std::nullopt;
  auto grown = fit_from_starts(problem, base, effect, candidate.free);
  if (!grown) {
    reasons.push_back(
        {effect->name, "", "with it the model predicts no image for some observations"});
    return std::nullopt;
  }
  candidate.grown = std::move(*grown);
  return candidate;
}

void judge(const Problem& problem, const Grown& base, double looks, Candidate& candidate) {
  const Assessment& before = base.assessment;
  const Assessment& after = candidate.grown.assessment;
  candidate.gain_ll = after.held_ll() - before.held_ll();
  candidate.total_gain_ll = after.total_ll - before.total_ll;
  candidate.at_bound = false;
  for (size_t k = 0; k < after.unknowns.size(); ++k) {
    if (after.unknowns[k].effect == candidate.effect->name && after.fit.at_bound[k])
      candidate.at_bound = true;
  }
  for (const Parameter& parameter : candidate.effect->parameters) {
    if (parameter.integer)
      looks *= static_cast<double>(problem.starts(before.model, *candidate.effect).size());
  }
  // Where the model misses more than the noise, likelihood ratios are worth less in proportion.
  const double misfit = std::max(1.0, after.error * after.error);
  const double ratio = 2 * candidate.total_gain_ll / misfit;
  const double freedom = static_cast<double>(std::max<size_t>(1, candidate.free.size()));
  const double tail = chi2_tail(ratio, freedom);
  candidate.p_value = tail <= 1e-299 ? 1e-300 : std::min(1.0, tail * looks);
  candidate.significant = candidate.p_value < kCandidateAlarm && candidate.gain_ll > 0;
  candidate.merit = merit_of(problem, candidate.grown);
}

void rank_candidates(std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     if (a.significant != b.significant) return a.significant;
                     return a.merit > b.merit;
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

Looks look_at(const Problem& problem, const Grown& base, const EffectList& effects) {
  std::vector<std::optional<Candidate>> found(effects.size());
  std::vector<std::vector<NotTestable>> reasons(effects.size());
  parallel_for(effects.size(),
               [&](size_t i) { found[i] = try_effect(problem, base, effects[i], reasons[i]); });
  Looks looks;
  double count = 0;
  for (const auto& candidate : found) count += candidate.has_value();
  for (size_t i = 0; i < effects.size(); ++i) {
    looks.not_testable.insert(looks.not_testable.end(), reasons[i].begin(), reasons[i].end());
    if (!found[i]) continue;
    judge(problem, base, count, *found[i]);
    looks.candidates.push_back(std::move(*found[i]));
  }
  rank_candidates(looks.candidates);
  return looks;
}

}  // namespace seam::measurement
