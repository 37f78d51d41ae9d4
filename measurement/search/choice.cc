#include "measurement/search/choice.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/parallel_for.h"
#include "measurement/search/decisions.h"
#include "measurement/search/material.h"

namespace seam::measurement {

Candidate* choose(const Problem& problem, const Grown& here, std::vector<Candidate>& candidates) {
  const bool misses = here.assessment.error > kMisfit;
  while (!candidates.empty() && candidates.front().significant) {
    Candidate& best = candidates.front();
    if (!best.effect->spread_only) return &best;
    const auto better = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
      return (problem.is_smooth(c.grown.assessment.model) && clearly_helps(c)) ||
             (misses && goes_before_spreads(c));
    });
    if (better != candidates.end()) return &*better;
    const Assessment& spread = best.grown.assessment;
    if (!misses ||
        (!hides_mean(problem, spread) && !leads_astray(problem, here.assessment, spread)))
      return &best;
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
    parallel_for(asked.size(), [&](size_t i) {
      ask_all_rows(problem, here, base, looks.tried, material, *asked[i]);
    });
    for (Candidate& candidate : looks.candidates) candidate.indistinguishable_from.clear();
    rank_candidates(looks.candidates);
  }
}

std::optional<Grown> fitted_better(const Problem& problem, const Grown& here, const Candidate* next,
                                   const std::vector<Candidate>& candidates) {
  constexpr double kWorth = 0.1;  // Of the candidate's gain.
  if (here.added.empty()) return std::nullopt;
  const Candidate* most = nullptr;
  double gain = next != nullptr ? next->total_gain_ll : 0;
  for (const Candidate& candidate : candidates) {
    if (!candidate.of_base || !(candidate.total_gain_ll > gain)) continue;
    most = &candidate, gain = candidate.total_gain_ll;
  }
  if (most == nullptr) return std::nullopt;
  Grown better = without(most->grown, most->effect->name);
  better.assessment = assess(problem, better.assessment.model, better.assessment.unknowns);
  const Assessment& after = better.assessment;
  if (!after.valid || !(after.total_ll > here.assessment.total_ll + kWorth * gain))
    return std::nullopt;
  return better;
}

std::optional<Grown> all_beside_motor(const Problem& problem, const Grown& here,
                                      const EffectList& own, const Candidate& next) {
  if (next.effect->errors != effects::Errors::together || !only_widens(*next.effect))
    return std::nullopt;
  auto all = with_dependents(problem, here, own);
  if (!all || !all->grown.assessment.valid || !(merit_of(problem, all->grown) > next.merit))
    return std::nullopt;
  return std::move(all->grown);
}

Candidate* largest_own_part(const Grown& here, std::vector<Candidate>& candidates) {
  Candidate* most = nullptr;
  for (Candidate& candidate : candidates) {
    const double error = candidate.grown.assessment.error;
    if (!candidate.of_base || only_widens(*candidate.effect) || !(candidate.own_ll > kAnyPrice) ||
        !(error < kPlainlyLess * here.assessment.error))
      continue;
    if (most == nullptr || candidate.own_ll > most->own_ll) most = &candidate;
  }
  return most;
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

bool falls_behind(const Grown& grown, double error_before, const Grown& rival) {
  const double error = grown.assessment.error;
  return error > kUseless && kPlainlyLess * error > rival.assessment.error &&
         error > kPlainlyLess * error_before;
}

bool all_useless(const Grown& base, const Looks& looks) {
  return base.assessment.error > kUseless &&
         std::all_of(looks.candidates.begin(), looks.candidates.end(), [](const Candidate& c) {
           return only_widens(*c.effect) || c.grown.assessment.error > kUseless;
         });
}

}  // namespace seam::measurement
