#include "measurement/search/choice.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "effects/questions.h"
#include "measurement/fitting/foretaste.h"
#include "measurement/fitting/group_scatter.h"
#include "measurement/judge/decisions.h"
#include "measurement/judge/material.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/regression.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {

Candidate* choose(const Problem& problem, const Grown& here, std::vector<Candidate>& candidates) {
  const bool misses = here.assessment.error > kMisfit;
  while (!candidates.empty() && candidates.front().significant) {
    Candidate& best = candidates.front();
    if (!best.effect->spread_only) return &best;
    if (!misses) return &best;
    const auto mean = std::find_if(candidates.begin(), candidates.end(), goes_before_spreads);
    if (mean != candidates.end()) return &*mean;
    if (!hides_mean(problem, here.assessment, best.grown.assessment)) return &best;
    best.significant = false, best.hides_mean = true;
    const auto end = std::find_if(candidates.begin() + 1, candidates.end(),
                                  [](const Candidate& c) { return !c.significant; });
    std::rotate(candidates.begin(), candidates.begin() + 1, end);
  }
  return nullptr;
}

namespace {

// Whether a candidate that few groups were asked of may be tied with another, fitted to all rows.
bool may_be_tied(const Candidate& few, const Candidate& with) {
  const double reach = kTieReach * tie_width(with.grown.assessment.error);
  const double there = with.grown.assessment.total_ll;
  return few.significant && few.grown.assessment.total_ll <= there + reach &&
         few.most_ll >= there - reach;
}

}  // namespace

Candidate* choose_by_all_rows(const Problem& problem, const Grown& here, double material,
                              Looks& looks) {
  for (;;) {
    Candidate* next = choose(problem, here, looks.candidates);
    if (next == nullptr) return nullptr;
    std::vector<Candidate*> asked;
    for (Candidate& candidate : looks.candidates) {
      if (candidate.of_few && (next->of_few ? &candidate == next : may_be_tied(candidate, *next)))
        asked.push_back(&candidate);
    }
    if (asked.empty()) return next;
    const Evaluation base =
        problem.evaluate_held_out(here.assessment.model, problem.scored_groups());
    const Work work("effects fitted to all rows", asked.size());
    parallel_for(asked.size(), [&](size_t i) {
      work.done();
      ask_all_rows(problem, here, base, looks.tried, material, *asked[i]);
    });
    for (Candidate& candidate : looks.candidates) candidate.indistinguishable_from.clear();
    rank_candidates(looks.candidates);
  }
}

bool clearly_needed(const Grown& grown, const std::string& name) {
  const Assessment& here = grown.assessment;
  const effects::ModelEffect* effect = here.model.find(name);
  for (size_t k = 0; k < here.unknowns.size() && k < here.fit.sigma.size(); ++k) {
    if (here.unknowns[k].effect != name) continue;
    // The first is the effect's size: a direction beside it is far from neutral where it has none.
    // Every value is infinitely far from a limit's neutral one: that says nothing.
    const double neutral = effect->definition->parameters[here.unknowns[k].parameter].neutral;
    return std::isfinite(neutral) &&
           std::abs(here.fit.value[k] - neutral) > kCannotGo * here.fit.sigma[k];
  }
  return false;
}

Grown without(const Grown& grown, const std::string& out) {
  Grown smaller{.added = grown.added};
  std::erase(smaller.added, out);
  Model model = grown.assessment.model;
  model.remove(out);
  std::vector<Unknown> unknowns = grown.assessment.unknowns;
  std::erase_if(unknowns, [&](const Unknown& u) { return u.effect == out; });
  smaller.assessment = {.model = model, .unknowns = unknowns};
  smaller.assessment.total_ll = -1e300;
  return smaller;
}

namespace {

struct Pruning {
  const EffectByName& definition;
  double looks, material;
};

// Whether an added effect is needed beside the others, fitted again without it.
bool is_missed(const Problem& problem, const Pruning& by, const Grown& grown,
               const std::string& name, const Grown& less) {
  Candidate back{.effect = by.definition(name), .grown = grown};
  for (const Unknown& unknown : grown.assessment.unknowns) {
    if (unknown.effect == name) back.free.push_back(unknown.parameter);
  }
  const Evaluation here = problem.evaluate(less.assessment.model, problem.scored_groups());
  judge(problem, less, here, by.looks, by.material, back);
  // What is plainly likelier stays, whatever it moves.
  const bool lost =
      grown.assessment.error < kMisfit && back.gain_ll > 0 && back.total_gain_ll > kAnyPrice;
  return back.significant || lost;
}

// Drops what does nothing where the fit put it, all at once: it takes one fit, not one of each.
bool drop_idle(const Problem& problem, Grown& grown) {
  const Groups all = problem.all_groups();
  const double enough = problem.score(grown.assessment.model, all).log_likelihood - kSameFit;
  Grown less = grown;
  for (const std::string& name : grown.added) {
    if (less.added.size() == 1 || effects::has_dependents(less.assessment.model, name)) continue;
    Grown smaller = without(less, name);
    const Score score = problem.score(smaller.assessment.model, all);
    if (score.valid && score.log_likelihood >= enough) less = std::move(smaller);
  }
  if (less.added.size() == grown.added.size()) return false;
  less.assessment = assess(problem, less.assessment.model, less.assessment.unknowns);
  if (!less.assessment.valid || less.assessment.total_ll < grown.assessment.total_ll - kTieWidth)
    return false;
  grown = std::move(less);
  return true;
}

}  // namespace

bool prune(const Problem& problem, const EffectByName& definition, double looks, double material,
           Grown& grown) {
  const Pruning by{definition, looks, material};
  bool changed = drop_idle(problem, grown);
  for (bool again = true; again && grown.added.size() > 1;) {
    again = false;
    std::vector<std::optional<Grown>> smaller(grown.added.size());
    const Work work("effects tried without", grown.added.size());
    parallel_for(grown.added.size(), [&](size_t i) {
      work.done();
      if (problem.is_smooth(grown.assessment.model) && clearly_needed(grown, grown.added[i]))
        return;
      if (effects::has_dependents(grown.assessment.model, grown.added[i])) return;
      Grown less = without(grown, grown.added[i]);
      if (stays_below(problem, less.assessment.model, less.assessment.unknowns,
                      grown.assessment.total_ll - kAnyPrice))
        return;
      less.assessment = assess(problem, less.assessment.model, less.assessment.unknowns);
      if (less.assessment.valid && !is_missed(problem, by, grown, grown.added[i], less))
        smaller[i] = std::move(less);
    });
    size_t best = grown.added.size();
    for (size_t i = 0; i < smaller.size(); ++i) {
      if (!smaller[i]) continue;
      if (best == smaller.size() || merit_of(*smaller[i]) > merit_of(*smaller[best])) best = i;
    }
    if (best < smaller.size()) {
      grown = std::move(*smaller[best]);
      changed = again = true;
    }
  }
  return changed;
}

namespace {

// A fitted value of an effect: how far the effect is from absent there, and the value's errors.
struct Amount {
  size_t unknown;      // Its place among the unknowns.
  double away, sigma;  // In the parameter's unit.
};

std::vector<Amount> amounts_of(const Assessment& stated, const std::string& name) {
  std::vector<Amount> amounts;
  const auto& parameters = stated.model.find(name)->definition->parameters;
  for (size_t k = 0; k < stated.unknowns.size() && k < stated.fit.sigma.size(); ++k) {
    if (stated.unknowns[k].effect != name) continue;
    const effects::Parameter& parameter = parameters[stated.unknowns[k].parameter];
    // A limit that never binds is absent at 0 of its reciprocal: there the distance is the value.
    const double value = stated.fit.value[k];
    const double away = std::isfinite(parameter.neutral) ? value - parameter.neutral
                        : std::isfinite(value)           ? -value
                                                         : 0;
    amounts.push_back({k, away, stated.fit.sigma[k]});
  }
  return amounts;
}

bool is_near(const Amount& amount) {
  return !(std::abs(amount.away) > kWithinError * amount.sigma);
}

// The square of the distance from neutral in errors, of these values together: two values that
// stand for each other are each within their errors, and clear of neutral as a pair.
double distance2(const Fit& fit, const std::vector<Amount>& near) {
  const auto n = static_cast<Eigen::Index>(near.size());
  const size_t all = fit.sigma.size();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n);
  Eigen::VectorXd away(n);
  const auto covariance = [&](size_t a, size_t b) {
    return fit.covariance[near[a].unknown * all + near[b].unknown];
  };
  for (size_t a = 0; a < near.size(); ++a) {
    const auto row = static_cast<Eigen::Index>(a);
    const double away_a = near[a].away / near[a].sigma;
    away[row] = std::isfinite(away_a) ? away_a : 0;
    for (size_t b = 0; b < near.size() && fit.covariance.size() == all * all; ++b) {
      const double size = std::sqrt(covariance(a, a) * covariance(b, b));
      if (a != b && size > 0 && std::isfinite(size))
        correlation(row, static_cast<Eigen::Index>(b)) = covariance(a, b) / size;
    }
  }
  constexpr double kFloor = 1e-9;
  return away.dot(floored_inverse(correlation, kFloor) * away);
}

// The model with these values of the effect at neutral.
Model at_neutral(const Assessment& here, const std::string& name,
                 const std::vector<Amount>& amounts) {
  Model model = here.model;
  const auto& parameters = here.model.find(name)->definition->parameters;
  for (const Amount& amount : amounts) {
    const size_t parameter = here.unknowns[amount.unknown].parameter;
    model.set_value(name, parameter, parameters[parameter].neutral);
  }
  return model;
}

}  // namespace

bool is_at_neutral(const Problem& problem, const Assessment& stated, const std::string& name) {
  const EffectDefinition& effect = *stated.model.find(name)->definition;
  if (!effect.has_neutral || has_counts(effect) || effects::has_dependents(stated.model, name))
    return false;
  const std::vector<Amount> all = amounts_of(stated, name);
  std::vector<Amount> near;
  std::copy_if(all.begin(), all.end(), std::back_inserter(near), is_near);
  if (near.empty() ||
      distance2(stated.fit, near) > chi2_at(kWithinError, static_cast<double>(near.size())))
    return false;
  if (near.size() == all.size()) return true;
  // A direction or a time says nothing where there is no size.
  const Groups groups = problem.all_groups();
  const Score less = problem.score(at_neutral(stated, name, near), groups);
  const Score none = problem.score(at_neutral(stated, name, all), groups);
  return less.valid && less.log_likelihood == none.log_likelihood;
}

bool remove_neutral(const Problem& problem, Grown& grown) {
  bool any = false;
  const Groups all = problem.all_groups();
  for (;;) {
    Assessment stated = grown.assessment;
    widen_by_group_scatter(problem, kMisfit, stated);
    const double unit = std::max(1.0, stated.error * stated.error);
    std::optional<Grown> best;
    for (const std::string& name : grown.added) {
      if (!is_at_neutral(problem, stated, name)) continue;
      Grown less = without(grown, name);
      less.assessment = assess(problem, less.assessment.model, less.assessment.unknowns);
      // The likelihood must agree with the errors, which a degenerate curvature makes of any size:
      // refitted, or, where that fit ends elsewhere, with all else as it is.
      const Score beside = problem.score(without(grown, name).assessment.model, all);
      const double kept = std::max(less.assessment.total_ll,
                                   beside.valid ? beside.log_likelihood : less.assessment.total_ll);
      const double lost = (grown.assessment.total_ll - kept) / unit;
      const double expected =
          0.5 * distance2(grown.assessment.fit, amounts_of(grown.assessment, name));
      if (!less.assessment.valid || !(lost < kTieWidth + expected)) continue;
      if (!best || less.assessment.total_ll > best->assessment.total_ll) best = std::move(less);
    }
    if (!best) return any;
    grown = *std::move(best);
    any = true;
  }
}

}  // namespace seam::measurement
