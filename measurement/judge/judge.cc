#include "measurement/judge/judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/judge/evidence.h"
#include "measurement/judge/material.h"
#include "measurement/numerics/regression.h"

namespace seam::measurement {
namespace {

using effects::Parameter;

double limit_of(const Assessment& assessment) {
  return limit_at_noise(static_cast<double>(std::max<int64_t>(1, assessment.held.n)));
}

// What is left of the noise: on held-out groups, or, where these are a handful of numbers, on all
// where that is less. What one group alone shows is found by no fit to the others.
double error_left(const Problem& problem, const Assessment& after) {
  if (after.held.n >= kFewHeldOut) return after.error;
  const Score all = problem.score(after.model, problem.all_groups());
  const double free = static_cast<double>(all.n) - static_cast<double>(after.unknowns.size());
  return all.valid && free > 0 ? std::min(after.error, std::sqrt(all.chi2 / free)) : after.error;
}

}  // namespace

bool has_counts(const EffectDefinition& effect) {
  return std::any_of(effect.parameters.begin(), effect.parameters.end(),
                     [](const Parameter& p) { return p.integer; });
}

namespace {

// A sum over its scatter, of what each group gains, or where they are fewer their blocks.
double over_scatter(const Score& before, const Score& after, size_t fewest_groups,
                    double (*scaled)(double gain), double least) {
  size_t units = 0;
  const auto statistic = [&](const std::vector<double>& from, const std::vector<double>& to) {
    double count = 0, sum = 0, sum2 = 0;
    for (size_t g = 0; g < to.size() && g < from.size(); ++g) {
      if (to[g] == 0 && from[g] == 0) continue;
      if (std::abs(to[g] - from[g]) < least) continue;
      const double gain = scaled(to[g] - from[g]);
      ++count, sum += gain, sum2 += gain * gain;
    }
    units = static_cast<size_t>(count);
    if (count < kLeastGroupsForScatter) return 0.0;
    const double variance = (sum2 - sum * sum / count) / (count - 1);
    return sum / std::sqrt(std::max(variance * count, 1e-300));
  };
  const double by_group = statistic(before.by_group, after.by_group);
  if (units >= fewest_groups || after.by_block.empty()) return by_group;
  return statistic(before.by_block, after.by_block);
}

}  // namespace

double gain_over_scatter(const Score& before, const Score& after, size_t fewest_groups) {
  return over_scatter(
      before, after, fewest_groups, [](double gain) { return gain; }, 0);
}

double root_gain_over_scatter(const Score& before, const Score& after, size_t fewest_groups) {
  constexpr double kSaysNothing = 1;  // Of log-likelihood: which noise alone gains or loses.
  return over_scatter(
      before, after, fewest_groups,
      [](double gain) { return std::copysign(std::sqrt(std::abs(gain)), gain); }, kSaysNothing);
}

double tie_width(double error) {
  return kTieWidth * std::max(1.0, error * error);
}

bool cannot_tell(double log_likelihood, double other, double error) {
  return std::abs(log_likelihood - other) < tie_width(error);
}

size_t fitted_parameters(const Candidate& candidate) {
  size_t count = candidate.free.size();
  for (const auto& companion : candidate.companions) {
    for (const Unknown& unknown : candidate.grown.assessment.unknowns)
      count += unknown.effect == companion->name;
  }
  return count;
}

double merit_of(const Grown& grown) {
  return grown.assessment.total_ll + occam_factor(grown.assessment);
}

void judge(const Problem& problem, const Grown& base, const Evaluation& here, double looks,
           double material, Candidate& candidate) {
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
  // A few numbers scatter more by themselves, which is no misfit.
  const double left = error_left(problem, after);
  const double limit = limit_of(after), excess = left * kMisfit / limit;
  const double misfit = std::max(1.0, excess * excess);
  const double freedom = static_cast<double>(std::max<size_t>(1, fitted_parameters(candidate)));
  const double tail = chi2_tail(2 * candidate.total_gain_ll / misfit, freedom);
  candidate.p_value = tail <= kLeastP ? kLeastP : std::min(1.0, tail * looks);
  candidate.fall = native_fall(before.held, after.held);
  const double evidence = candidate.total_gain_ll / misfit + occam_factor(after) -
                          occam_factor(before) - std::log(looks);
  // Beyond the noise a likelihood says little: held-out groups must agree that they gain.
  const bool agreed =
      candidate.gain_ll > kUnluckyLoss &&
      (left <= limit || root_gain_over_scatter(before.held, after.held) > kAgreedGain);
  candidate.significant =
      evidence > kOdds && agreed && problem.is_visible(before.model, after.model);
  if (candidate.significant) {
    const bool widens = only_widens(*candidate.effect);
    const Change change = change_by(problem, here, before, after, widens);
    candidate.moved = change.moved;
    const bool explains = !widens || change.at_noise;
    candidate.trace = explains && candidate.moved < material;
    candidate.significant = explains && !candidate.trace;
  }
  candidate.merit = merit_of(candidate.grown);
}

bool only_widens(const EffectDefinition& effect) {
  return effect.spread_only && !effect.draws_estimated;
}

bool goes_before_spreads(const Candidate& candidate) {
  return candidate.significant && !candidate.effect->spread_only && candidate.fall > kHeardFirst;
}

void rank_candidates(std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Candidate& a, const Candidate& b) {
                     if (a.significant != b.significant) return a.significant;
                     return a.merit > b.merit;
                   });
  for (Candidate& candidate : candidates) {
    if (!candidate.significant) continue;
    for (const Candidate& other : candidates) {
      const double error = std::min(candidate.grown.assessment.error, other.grown.assessment.error);
      if (&other != &candidate && other.significant &&
          candidate.indistinguishable_from.size() < kMostTiesNamed &&
          cannot_tell(candidate.total_gain_ll, other.total_gain_ll, error))
        add_once(candidate.indistinguishable_from, other.effect->name);
    }
  }
}

std::vector<Candidate> traces_of(const std::vector<Candidate>& candidates) {
  std::vector<Candidate> traces;
  std::copy_if(candidates.begin(), candidates.end(), std::back_inserter(traces),
               [](const Candidate& c) { return c.trace; });
  return traces;
}

void add_once(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

void remember_significant(const std::vector<Candidate>& candidates,
                          std::vector<std::string>& names) {
  for (const Candidate& candidate : candidates) {
    if (candidate.significant && names.size() < kMostPromising)
      add_once(names, candidate.effect->name);
  }
}

}  // namespace seam::measurement
