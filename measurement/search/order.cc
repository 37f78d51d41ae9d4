#include "measurement/search/order.h"

#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "measurement/fitting/group_scatter.h"
#include "measurement/judge/doubted.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/search/choice.h"
#include "measurement/search/kept.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

// By scalar: the change of the prediction in units of the noise, then that of the standard
// deviation. Empty where a kind has no residual vectors.
std::vector<double> change_of(const Problem& problem, const Evaluation& here,
                              const Candidate& candidate) {
  const Evaluation there =
      problem.evaluate(candidate.grown.assessment.model, problem.scored_groups());
  if (here.used.empty() || there.used.empty() || !here.valid || !there.valid) return {};
  const size_t n = here.used.size();
  std::vector<double> change(2 * n, 0);
  for (size_t i = 0; i < n; ++i) {
    if (!here.used[i] || !there.used[i] || !(here.sigma[i] > 0)) continue;
    change[i] = (here.residual[i] - there.residual[i]) / here.sigma[i];
    change[n + i] = there.sigma[i] / here.sigma[i] - 1;
  }
  return change;
}

double likeness(const std::vector<double>& a, const std::vector<double>& b) {
  double aa = 0, bb = 0, ab = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    aa += a[i] * a[i], bb += b[i] * b[i], ab += a[i] * b[i];
  return aa > 0 && bb > 0 ? std::abs(ab) / std::sqrt(aa * bb) : 0;
}

// Moves the effects found to the front, in the order of the steps; returns how many there are.
size_t found_first(SearchResult& result) {
  auto& candidates = result.first.candidates;
  size_t count = 0;
  for (const Step& step : result.steps) {
    const auto place = candidates.begin() + static_cast<std::ptrdiff_t>(count);
    const auto it = std::find_if(place, candidates.end(),
                                 [&](const Candidate& c) { return c.effect->name == step.effect; });
    if (it == candidates.end()) continue;
    it->found = it->significant = true, it->trace = false;
    // What one of several looks like alone is no tie of the whole.
    if (result.steps.size() > 1) it->indistinguishable_from = step.indistinguishable_from;
    std::rotate(place, it, it + 1);
    ++count;
  }
  return count;
}

// Behind the effects found, those that help alone, then those that do not, each by the likelihood
// of held-out groups. Where nothing was found, what seemed to help and lies within its stated
// errors of neutral helps no longer.
void others_by_likelihood(const Problem& problem, size_t found, SearchResult& result) {
  auto& candidates = result.first.candidates;
  for (Candidate& candidate : candidates) {
    if (found > 0 || !candidate.significant) continue;
    Assessment stated = candidate.grown.assessment;
    widen_by_group_scatter(problem, kMisfit, stated);
    if (is_at_neutral(problem, stated, candidate.effect->name)) candidate.significant = false;
  }
  std::stable_sort(candidates.begin() + static_cast<std::ptrdiff_t>(found), candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     if (a.significant != b.significant) return a.significant;
                     return a.gain_ll > b.gain_ll;
                   });
}

// An effect and the first that is left of those that the search offers with it: alone it seldom
// helps.
std::vector<std::string> together(const EffectByName& effect_by_name,
                                  const std::vector<std::string>& left, size_t i) {
  std::vector<std::string> names = {left[i]};
  for (const std::string& companion : effect_by_name(left[i])->companions) {
    if (std::find(left.begin(), left.end(), companion) != left.end()) names.push_back(companion);
    if (names.size() > 1) break;
  }
  return names;
}

// A model less those of its effects that are left, but for these, fitted again from its own values.
Grown part_of(const Problem& problem, const Grown& whole, const std::vector<std::string>& left,
              const std::vector<std::string>& kept) {
  if (kept.size() == left.size()) return whole;
  Grown part = whole;
  for (const std::string& name : left) {
    if (std::find(kept.begin(), kept.end(), name) == kept.end()) part = without(part, name);
  }
  part.assessment = assess(problem, part.assessment.model, part.assessment.unknowns);
  return part;
}

// Draws and errors that hang together can stand for any misfit while a mean is missing, and single
// large errors for draws as well: of those that are left only the lowest turn comes.
int turn_of(const EffectDefinition& effect) {
  if (effect.errors == effects::Errors::now_and_then) return 2;
  return effect.draws_estimated || effect.errors == effects::Errors::together ? 1 : 0;
}

// Beside what was given the first look fitted each effect, under the same marks.
std::optional<Candidate> seen_first(const SearchResult& result, const Grown& grown,
                                    const std::string& name) {
  if (!grown.added.empty() || !result.first_is_of_base) return std::nullopt;
  for (const Candidate& candidate : result.first.candidates) {
    if (candidate.effect->name == name && candidate.companions.empty() && !candidate.of_few)
      return candidate;
  }
  return std::nullopt;
}

double moved(const Problem& problem, const Assessment& before, const Assessment& after,
             const EffectDefinition& by) {
  const Evaluation here = problem.evaluate_held_out(before.model, problem.scored_groups());
  return change_by(problem, here, before, after, only_widens(by)).moved;
}

// A step for each of the effects that come together, with their values in the model that has all of
// them: the error of the first ones alone is what they leave of it there, not fitted again.
void take_steps(const Problem& problem, const EffectByName& effect_by_name, Grown after,
                const std::vector<std::string>& names, Grown& grown, SearchResult& result) {
  for (size_t k = 0; k < names.size(); ++k) {
    Grown here = after;
    for (size_t later = k + 1; later < names.size(); ++later) here = without(here, names[later]);
    if (k + 1 < names.size()) here.assessment = assess_fixed(problem, here.assessment.model);
    Step step{.effect = names[k], .after = after.assessment};
    step.error_before = grown.assessment.error, step.error_after = here.assessment.error;
    step.moved = moved(problem, grown.assessment, here.assessment, *effect_by_name(names[k]));
    result.steps.push_back(std::move(step));
    grown = std::move(here);
  }
}

}  // namespace

void tell_ties(const Problem& problem, const EffectByName& effect_by_name,
               const Exchanges& exchanges, const Grown& searched,
               const std::vector<std::string>& promising, SearchResult& result) {
  result.ties_sought = searched.assessment.error < kMisfit && !result.unnamed &&
                       result.mimics.empty() && !has_mean_structure(result.remaining);
  if (!result.ties_sought) return;
  std::vector<std::pair<size_t, std::string>> moves;
  for (size_t s = 0; s < result.steps.size(); ++s) {
    if (effects::has_dependents(result.best.assessment.model, result.steps[s].effect)) continue;
    for (const std::string& name : promising) {
      if (!result.best.assessment.model.has(name)) moves.emplace_back(s, name);
    }
  }
  std::vector<char> tied(moves.size(), 0);
  const Work work("ties looked for", moves.size());
  parallel_for(moves.size(), [&](size_t m) {
    work.done();
    const auto other = exchanges.with_other(searched, result.steps[moves[m].first].effect,
                                            effect_by_name(moves[m].second));
    if (!other) return;
    tied[m] = cannot_tell(searched.assessment.total_ll, other->assessment.total_ll,
                          searched.assessment.error) ||
              !problem.is_visible(searched.assessment.model, other->assessment.model);
  });
  for (size_t m = 0; m < moves.size(); ++m) {
    auto& names = result.steps[moves[m].first].indistinguishable_from;
    if (tied[m] && names.size() < kMostTiesNamed) add_once(names, moves[m].second);
  }
}

void order_steps(const Problem& problem, const EffectByName& effect_by_name, SearchResult& result) {
  result.steps.clear();
  const bool explained = result.best.assessment.error < kMisfit;
  Grown grown = result.base;
  std::vector<std::string> left = result.best.added;
  while (!left.empty()) {
    std::vector<std::optional<Candidate>> tried(left.size());
    const Work work("steps put in order", result.best.added.size());
    for (size_t done = left.size(); done < result.best.added.size(); ++done) work.done();
    // Where they do not explain the set, the order in which the search took them is good enough.
    parallel_for(explained ? left.size() : 1, [&](size_t i) {
      std::vector<NotTestable> reasons;
      const auto effect = effect_by_name(left[i]);
      if (effects::is_excluded(*effect, grown.assessment.model)) return;
      const bool last = left.size() == 1;
      if (explained && std::any_of(left.begin(), left.end(), [&](const std::string& name) {
            return turn_of(*effect_by_name(name)) < turn_of(*effect);
          }))
        return;
      if (effect->companions.empty() && !last) {
        tried[i] = seen_first(result, grown, left[i]);
        if (tried[i]) return;
        tried[i] = try_effect(problem, grown, effect, reasons);
      }
      // Found after another that it replaced, or with others: what was fitted last is the place to
      // start from.
      if (tried[i]) return;
      Grown part = part_of(problem, result.best, left, together(effect_by_name, left, i));
      if (part.assessment.valid) tried[i] = Candidate{.grown = std::move(part)};
    });
    size_t best = left.size();
    for (size_t i = 0; i < left.size(); ++i) {
      if (tried[i] && (best == left.size() || tried[i]->grown.assessment.total_ll >
                                                  tried[best]->grown.assessment.total_ll))
        best = i;
    }
    if (best == left.size()) break;
    const std::vector<std::string> names = together(effect_by_name, left, best);
    take_steps(problem, effect_by_name, std::move(tried[best]->grown), names, grown, result);
    std::erase_if(left, [&](const std::string& name) {
      return std::find(names.begin(), names.end(), name) != names.end();
    });
  }
  if (grown.assessment.valid && !result.steps.empty() &&
      grown.assessment.total_ll >= result.best.assessment.total_ll - kSameFit) {
    result.best = grown;
  }
}

std::vector<std::string> noises_found(const SearchResult& result) {
  std::vector<std::string> names;
  for (const Step& step : result.steps) {
    const effects::ModelEffect* effect = result.best.assessment.model.find(step.effect);
    if (effect != nullptr && only_widens(*effect->definition)) names.push_back(step.effect);
  }
  return names;
}

std::vector<std::string> noises_of_unknown_cause(const SearchResult& result) {
  std::vector<std::string> names;
  for (const Step& step : result.steps) {
    const effects::ModelEffect* effect = result.best.assessment.model.find(step.effect);
    if (effect != nullptr && effect->definition->unknown_cause) names.push_back(step.effect);
  }
  return names;
}

bool explained_by_noises(const SearchResult& result) {
  return result.verdict == "missing_effect" && result.remaining.empty() &&
         noises_found(result).size() == result.steps.size();
}

namespace {

// Says of each step what speaks against it; returns whether anything does.
bool doubt_steps(const Problem& problem, SearchResult& result) {
  Assessment stated = result.best.assessment;
  widen_by_group_scatter(problem, kMisfit, stated);
  std::vector<std::string> named;
  for (const Step& step : result.steps) named.push_back(step.effect);
  const auto doubts = doubts_of(problem, stated, named);
  bool any = false;
  for (size_t k = 0; k < named.size(); ++k) {
    any = any || !doubts[k].empty();
    result.steps[k].doubts = doubts[k];
  }
  return any;
}

}  // namespace

void give_verdict(const Problem& problem, const SplitStructure& of_base, SearchResult& result) {
  const bool is_given = result.steps.empty() && result.kept.empty();
  const SplitStructure of_best =
      is_given ? of_base : significant_structure(problem, result.best.assessment, result.material);
  result.base_structure = of_base.material, result.base_traces = of_base.traces;
  result.remaining = of_best.material, result.remaining_traces = of_best.traces;
  const bool first_found =
      !result.first.candidates.empty() && result.first.candidates.front().significant;
  const bool has_error = std::isfinite(result.best.assessment.error);
  const bool structure_left =
      !result.remaining.empty() && (has_mean_structure(result.remaining) || !first_found);
  const bool doubted = doubt_steps(problem, result);
  if (!has_error || result.unnamed || !result.mimics.empty() || structure_left || doubted) {
    result.verdict = "unexplained_structure";
  } else {
    result.verdict = result.steps.empty() ? "adequate" : "missing_effect";
  }
}

void rank_by_search(const Problem& problem, SearchResult& result) {
  const size_t found = found_first(result);
  others_by_likelihood(problem, found, result);
  if (found == 0) return;
  constexpr double kAlike = 0.5;  // The cosine of 60 degrees.
  auto& candidates = result.first.candidates;
  const Evaluation here = problem.evaluate(result.base.assessment.model, problem.scored_groups());
  std::vector<std::vector<double>> changes;
  for (size_t k = 0; k < found; ++k) changes.push_back(change_of(problem, here, candidates[k]));
  for (size_t i = found; i < candidates.size(); ++i) {
    Candidate& candidate = candidates[i];
    if (!candidate.significant) continue;
    const std::vector<double> change = change_of(problem, here, candidate);
    for (size_t k = 0; k < found; ++k) {
      if (likeness(change, changes[k]) > kAlike)
        candidate.stands_in_for.push_back(candidates[k].effect->name);
    }
    // Like none of them alone: for all of them together.
    if (!candidate.stands_in_for.empty()) continue;
    for (size_t k = 0; k < found; ++k)
      candidate.stands_in_for.push_back(candidates[k].effect->name);
  }
}

}  // namespace seam::measurement
