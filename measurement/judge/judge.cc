#include "measurement/judge/judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/judge/material.h"
#include "measurement/numerics/regression.h"

namespace seam::measurement {
namespace {

using effects::Parameter;

// Fitted parameters of an effect that are clearly away from neutral.
size_t clear_parameters(const Grown& grown, const std::string& name) {
  const effects::ModelEffect* effect = grown.assessment.model.find(name);
  size_t clear = 0;
  for (size_t k = 0; k < grown.assessment.unknowns.size(); ++k) {
    const Unknown& unknown = grown.assessment.unknowns[k];
    if (unknown.effect != name) continue;
    const double away = std::abs(grown.assessment.fit.value[k] -
                                 effect->definition->parameters[unknown.parameter].neutral);
    clear += away > kClearlyAway * grown.assessment.fit.sigma[k];
  }
  return clear;
}

size_t needed_parameters(const Grown& grown) {
  size_t needed = 0;
  for (const std::string& name : grown.added)
    needed += std::max<size_t>(1, clear_parameters(grown, name));
  return needed;
}

bool bounded_at_neutral(const EffectDefinition& effect) {
  return std::any_of(effect.parameters.begin(), effect.parameters.end(),
                     [](const Parameter& p) { return p.min >= p.neutral || p.max <= p.neutral; });
}

// Whether the fitted values are told at all: none has an error beyond its own size and many times
// what is typical of it.
bool is_known(const Assessment& assessment) {
  constexpr double kManyTimes = 10;
  for (size_t k = 0; k < assessment.unknowns.size(); ++k) {
    const Unknown& unknown = assessment.unknowns[k];
    const Parameter& parameter =
        assessment.model.find(unknown.effect)->definition->parameters[unknown.parameter];
    if (assessment.fit.sigma[k] >
        std::max(std::abs(assessment.fit.value[k]), kManyTimes * parameter.scale))
      return false;
  }
  return true;
}

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

bool is_at_noise(const Assessment& assessment) {
  return assessment.error <= limit_of(assessment);
}

// What the model loses without the effect, all else as it is: at least what the effect gained, or
// else some of that gain is the base's, whose fit had stopped early.
double loss_without(const Problem& problem, const Candidate& candidate) {
  const Model& with = candidate.grown.assessment.model;
  Model without = with;
  without.remove(candidate.effect->name);
  const Score there = problem.score_beside(without, problem.all_groups(), with);
  return there.valid ? candidate.grown.assessment.total_ll - there.log_likelihood
                     : std::numeric_limits<double>::infinity();
}

// Whether a value that was known is so no longer: the effect and others that are fitted stand for
// one another.
bool blurs(const Assessment& before, const Assessment& after) {
  for (size_t k = 0; k < before.unknowns.size(); ++k) {
    const auto there = index_of(after.unknowns, before.unknowns[k]);
    const double known = before.fit.sigma[k];
    if (there && known > 0 && after.fit.sigma[*there] > kBlurred * known) return true;
  }
  return false;
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

bool falls_behind(const Assessment& here, double error_before, const Assessment& rival) {
  return here.error > kUseless && kPlainlyLess * here.error > rival.error &&
         here.error > kPlainlyLess * error_before;
}

double tie_width(double error) {
  return kTieWidth * std::max(1.0, error * error);
}

size_t fitted_parameters(const Grown& grown) {
  size_t count = 0;
  for (const Unknown& unknown : grown.assessment.unknowns) {
    count += std::find(grown.added.begin(), grown.added.end(), unknown.effect) != grown.added.end();
  }
  return count;
}

bool is_lens(const EffectDefinition& effect) {
  return effect.term == effects::Term::radial || effects::replaces(effect, effects::Term::radial);
}

bool are_lenses(const EffectDefinition& one, const EffectDefinition& other) {
  return is_lens(one) && is_lens(other) &&
         effects::camera_of(one.name) == effects::camera_of(other.name);
}

Weight weight_of(const Grown& grown) {
  return {grown.assessment.total_ll, fitted_parameters(grown)};
}

bool cannot_tell(const Weight& a, const Weight& b, double error) {
  const double ahead = a.total_ll - b.total_ll;
  if (std::abs(ahead) < tie_width(error)) return true;
  const bool a_has_more = a.parameters > b.parameters;
  if (a.parameters == b.parameters || a_has_more != (ahead > 0)) return false;
  const double further =
      static_cast<double>(a_has_more ? a.parameters - b.parameters : b.parameters - a.parameters);
  return chi2_tail(2 * std::abs(ahead) / std::max(1.0, error * error), further) > kTieAlarm;
}

size_t fitted_parameters(const Candidate& candidate) {
  size_t count = candidate.free.size();
  for (const auto& companion : candidate.companions) {
    for (const Unknown& unknown : candidate.grown.assessment.unknowns)
      count += unknown.effect == companion->name;
  }
  return count;
}

double merit_of(const Problem& problem, const Grown& grown) {
  const double size = std::log(static_cast<double>(std::max<size_t>(count_used(problem), 3)));
  const size_t needed = needed_parameters(grown);
  const size_t fitted = std::max(fitted_parameters(grown), needed);
  return grown.assessment.total_ll - kPriceOfClear * size * static_cast<double>(needed) -
         kPriceOfUnclear * static_cast<double>(fitted - needed);
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
  const double ratio = 2 * candidate.total_gain_ll / misfit;
  const double freedom = static_cast<double>(std::max<size_t>(1, fitted_parameters(candidate)));
  const double tail = chi2_tail(ratio, freedom);
  candidate.p_value = tail <= 1e-299 ? 1e-300 : std::min(1.0, tail * looks);
  // One parameter gains as much as it stands clear of neutral; a gain without is the base's, whose
  // fit had stopped early. Where the base itself is not known (the focal length of a camera that
  // sees a board from the front only), no value is clear: whether the gain is lost without it tells
  // then.
  // Draws free the mean from what single groups did to it: that gain is their own.
  const bool lost_tells = candidate.effect->has_neutral && !has_counts(*candidate.effect) &&
                          !candidate.effect->draws_estimated;
  const bool clear = has_counts(*candidate.effect) || candidate.effect->spread_only ||
                     clear_parameters(candidate.grown, candidate.effect->name) > 0;
  candidate.fall = native_fall(before.held, after.held);
  // Beyond the noise a likelihood says little: held-out groups must agree that they gain, and some
  // value be clear, unless the gain is plain; and residuals fall in their own units.
  const bool mean = !only_widens(*candidate.effect);
  const bool plain = mean && after.error < kPlainlyLess * before.error;
  const bool falls = !mean || before.error <= limit || candidate.fall > 0;
  const bool agreed = left <= limit
                          ? clear || candidate.free.size() > 1 || (lost_tells && !is_known(before))
                          : falls && (plain || (clear && candidate.held_z > kAgreedGain));
  candidate.significant =
      candidate.p_value < kCandidateAlarm && agreed &&
      held_out_agree(candidate.p_value, candidate.gain_ll, candidate.held_z, left < limit) &&
      problem.is_visible(before.model, after.model);
  // What stands for others must be worth more than any price: a lens's prism and decentring
  // together turn its axis by ten degrees, at no cost but their own size.
  if (candidate.significant && candidate.total_gain_ll < kAnyPrice * misfit && blurs(before, after))
    candidate.significant = false;
  if (candidate.significant && lost_tells) {
    candidate.own_ll = loss_without(problem, candidate);
    candidate.of_base = !(candidate.own_ll > kOwnShareOfGain * candidate.total_gain_ll);
  }
  candidate.significant = candidate.significant && !candidate.of_base;
  if (candidate.significant) {
    const Change change = change_by(problem, here, before, after, only_widens(*candidate.effect));
    candidate.moved = change.moved;
    candidate.significant = mean || change.at_noise;
    candidate.trace = candidate.significant && candidate.moved < material;
    candidate.significant = candidate.significant && !candidate.trace;
  }
  candidate.merit = merit_of(problem, candidate.grown);
}

bool only_widens(const EffectDefinition& effect) {
  return effect.spread_only && !effect.draws_estimated;
}

bool clearly_helps(const Candidate& candidate) {
  return candidate.significant && !candidate.effect->spread_only && candidate.held_z > kClearGain;
}

bool goes_before_spreads(const Candidate& candidate) {
  return candidate.significant && !candidate.effect->spread_only && candidate.fall > kHeardFirst;
}

namespace {

Weight weight_of(const Candidate& candidate) {
  return {candidate.total_gain_ll, fitted_parameters(candidate)};
}

// Moves those that the data cannot tell from the best, or from one of these, to the front, and
// returns how many there are; the chain ends where one is clearly worse than the best. Where even
// the best misses more than the noise, what is missing weighs more than parameters do: there only
// those within the width of a tie belong to it.
size_t gather_ties(std::vector<Candidate>& candidates) {
  const double error = candidates.front().grown.assessment.error;
  const double width = tie_width(error);
  const Weight best = weight_of(candidates.front());
  const double best_merit = candidates.front().merit;
  size_t count = 1;
  const auto joins = [&](const Candidate& c) {
    if (!c.significant) return false;
    if (error > limit_of(candidates.front().grown.assessment))
      return best_merit - c.merit < width && std::abs(best.total_ll - c.total_gain_ll) < width;
    if (std::abs(best.total_ll - c.total_gain_ll) > kTieReach * width) return false;
    return std::any_of(candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
                       [&](const Candidate& member) {
                         return cannot_tell(weight_of(member), weight_of(c), error);
                       });
  };
  for (bool again = true; again;) {
    again = false;
    for (size_t i = count; i < candidates.size(); ++i) {
      if (!joins(candidates[i])) continue;
      const auto place = candidates.begin() + static_cast<std::ptrdiff_t>(count);
      const auto here = candidates.begin() + static_cast<std::ptrdiff_t>(i);
      std::rotate(place, here, here + 1);
      ++count, again = true;
    }
  }
  return count;
}

// How the distance from the axis is bent every lens has, before any rarer cause of the same image.
bool of_every_lens(const Candidate& candidate) {
  return candidate.effect->term == effects::Term::radial;
}

// Of equally good ones: fewer parameters, then what every lens has, then no bound at neutral.
void simplest_first(std::vector<Candidate>& candidates, size_t tied) {
  const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(tied);
  const bool at_noise = is_at_noise(candidates.front().grown.assessment);
  // Whether a wider family of lenses is needed shows once all else is explained.
  const double lenses = tie_width(candidates.front().grown.assessment.error);
  std::stable_sort(candidates.begin(), end, [&](const Candidate& a, const Candidate& b) {
    const double apart = std::abs(a.total_gain_ll - b.total_gain_ll);
    const size_t of_a = fitted_parameters(a), of_b = fitted_parameters(b);
    const double fewer = are_lenses(*a.effect, *b.effect) ? lenses : kFewerParametersWidth;
    if (of_a != of_b && (at_noise || apart < fewer)) return of_a < of_b;
    if (at_noise && of_every_lens(a) != of_every_lens(b)) return of_every_lens(a);
    if (apart < kPreferenceWidth)
      return !bounded_at_neutral(*a.effect) && bounded_at_neutral(*b.effect);
    return false;
  });
}

}  // namespace

void rank_candidates(std::vector<Candidate>& candidates) {
  // While nothing explains the set by far, training groups can be fitted by what is wrong
  // elsewhere.
  const bool far = std::all_of(candidates.begin(), candidates.end(), [](const Candidate& c) {
    return c.grown.assessment.error > kUseless;
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const Candidate& a, const Candidate& b) {
                     if (a.significant != b.significant) return a.significant;
                     return far ? a.gain_ll > b.gain_ll : a.merit > b.merit;
                   });
  if (candidates.empty() || !candidates.front().significant) return;
  const size_t tied = gather_ties(candidates);
  simplest_first(candidates, tied);
  const bool at_noise = is_at_noise(candidates.front().grown.assessment);
  for (size_t i = 0; i < candidates.size(); ++i) {
    Candidate& candidate = candidates[i];
    if (!candidate.significant) continue;
    const double error = candidate.grown.assessment.error;
    for (size_t k = 0; k < candidates.size(); ++k) {
      const Candidate& other = candidates[k];
      if (k == i || !other.significant) continue;
      const bool in_class = at_noise && i < tied && k < tied;
      const bool pair =
          std::abs(other.total_gain_ll - candidate.total_gain_ll) < tie_width(error) &&
          candidate.indistinguishable_from.size() < kMostTiesNamed;
      if (in_class || pair) add_once(candidate.indistinguishable_from, other.effect->name);
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
