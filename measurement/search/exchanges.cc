#include "measurement/search/exchanges.h"

#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/registry.h"
#include "measurement/judge/decisions.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/search/choice.h"
#include "measurement/search/told_apart.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {

namespace {

// What takes the place of another base is exchanged for its like alone: without it the model is
// none from which a step could tell anything.
bool may_take_the_place(const EffectDefinition& in, const EffectDefinition& leaving) {
  return leaving.replaces_base == effects::Base::none ||
         in.replaces_base == leaving.replaces_base || effects::replaces(leaving, in.term);
}

// Whether it says how the distance from the axis is bent.
bool is_lens(const EffectDefinition& effect) {
  return effect.term == effects::Term::radial || effects::replaces(effect, effects::Term::radial);
}

// Whether the exchange is another than the one of these two: an effect that pushes out more of what
// was added does less than the same in the place of what it pushes out, and a lens of one camera
// says nothing of another's.
bool is_another(const EffectDefinition& in, const EffectDefinition& leaving, const Grown& smaller) {
  if (is_lens(in) && is_lens(leaving)) {
    const std::string of_in = effects::camera_of(in.name), of_it = effects::camera_of(leaving.name);
    return !of_in.empty() && !of_it.empty() && of_in != of_it;
  }
  Model rest = smaller.assessment.model;
  effects::remove_replaced(in, rest);
  return std::any_of(smaller.added.begin(), smaller.added.end(),
                     [&](const std::string& name) { return !rest.has(name); });
}

// Whether the exchange is no tie, and far from better, as few groups tell.
bool is_far_behind(const Problem& problem, const Grown& grown, const Grown& smaller,
                   const std::shared_ptr<const EffectDefinition>& in) {
  const auto few = foretasters(problem, smaller.assessment.model, kMaterial);
  if (!few) return false;
  std::vector<NotTestable> reasons;
  const auto prospect =
      prospect_of(problem, smaller, in, reasons, /*alone=*/true, /*near=*/nullptr, &*few);
  if (!prospect || !reasons.empty() || !prospect->few) return false;
  const auto candidate = fit_prospect(problem, smaller, *prospect, reasons);
  return candidate && candidate->most_ll <
                          grown.assessment.total_ll - kTieReach * tie_width(grown.assessment.error);
}

// Fits an effect from where the kind says that it does what another did: an exchange of lenses.
std::optional<Grown> from_its_like(const Problem& problem, const Grown& grown, const Grown& smaller,
                                   const std::shared_ptr<const EffectDefinition>& in) {
  Prospect prospect{.effect = in, .starts = problem.starts(grown.assessment.model, *in)};
  if (prospect.starts.empty()) return std::nullopt;
  for (size_t i = 0; i < in->parameters.size(); ++i) {
    if (!in->parameters[i].integer && !in->parameters[i].stated) prospect.free.push_back(i);
  }
  std::vector<NotTestable> reasons;
  auto candidate = fit_prospect(problem, smaller, prospect, reasons);
  if (!candidate) return std::nullopt;
  return std::move(candidate->grown);
}

// What came last stands where what went stood: steps are told in that order where they explain too
// little to be ordered by what each does.
std::optional<Grown> in_its_place(const Grown& grown, const std::string& out,
                                  std::optional<Grown> other) {
  if (!other) return other;
  auto& added = other->added;
  const auto place = std::find(grown.added.begin(), grown.added.end(), out) - grown.added.begin();
  if (place < std::ssize(added)) std::rotate(added.begin() + place, added.end() - 1, added.end());
  return other;
}

std::vector<double> key_of(const Problem& problem, const Grown& grown,
                           const std::vector<std::string>& change) {
  std::vector<double> key = key_of(problem, grown.assessment);
  for (const std::string& name : change) add_to_key(name, key);
  for (const std::string& name : grown.added) add_to_key(name, key);
  return key;
}

}  // namespace

std::vector<Exchange> possible_exchanges(const Problem& problem, const Grown& grown,
                                         const std::vector<std::string>& promising,
                                         const EffectByName& effect_by_name) {
  std::vector<Exchange> moves;
  const auto& added = grown.added;
  for (const std::string& out : added) {
    if (effects::has_dependents(grown.assessment.model, out)) continue;
    // Lenses whose looks failed from far away, too: one camera's for its own.
    const std::string camera = effects::camera_of(out);
    for (const auto& effect : effects::catalogue()) {
      if (problem.acts(*effect) && stands_for(*effect_by_name(out), *effect))
        moves.push_back({out, camera.empty() ? effect->name : effect->name + "@" + camera});
    }
    for (const std::string& name : promising) {
      if (added.size() < 2 ||
          std::find(moves.begin(), moves.end(), Exchange{out, name}) != moves.end())
        continue;
      const bool present = std::find(added.begin(), added.end(), name) != added.end();
      // A spread in the place of an effect of the mean would hide it; the other way round, the
      // effect of the mean is added first and then the spread is dropped.
      if (!present && effect_by_name(name)->spread_only == effect_by_name(out)->spread_only)
        moves.push_back({out, name});
    }
  }
  return moves;
}

bool stands_for(const EffectDefinition& leaving, const EffectDefinition& in) {
  if (in.term != effects::Term::radial) return false;
  const bool narrower = in.term == leaving.term && in.parameters.size() < leaving.parameters.size();
  return effects::replaces(leaving, in.term) || narrower;
}

std::optional<size_t> best_exchange(const Grown& grown,
                                    const std::vector<std::optional<Grown>>& tried) {
  // Less is within what two fits of one model differ by, and the search would go round in circles.
  double most = merit_of(grown) + kExchangeGain * tie_width(grown.assessment.error);
  std::optional<size_t> best;
  for (size_t m = 0; m < tried.size(); ++m) {
    if (!tried[m] || tried[m]->assessment.held_ll() < grown.assessment.held_ll() + kUnluckyLoss)
      continue;
    const double merit = merit_of(*tried[m]);
    if (merit > most) most = merit, best = m;
  }
  return best;
}

std::vector<std::optional<Grown>> Exchanges::tried(const Grown& grown,
                                                   const std::vector<Exchange>& moves,
                                                   const EffectByName& effect_by_name) const {
  std::vector<std::optional<Grown>> tried(moves.size());
  const Work work("exchanges tried", moves.size());
  parallel_for(moves.size(), [&](size_t m) {
    tried[m] = with_other(grown, moves[m].out, effect_by_name(moves[m].in));
    work.done();
  });
  return tried;
}

std::optional<Grown> Exchanges::better(const Grown& grown,
                                       const std::vector<std::string>& promising,
                                       const EffectByName& effect_by_name) const {
  const auto moves = possible_exchanges(problem_, grown, promising, effect_by_name);
  const auto once = tried(grown, moves, effect_by_name);
  const auto best = best_exchange(grown, once);
  return best ? once[*best] : std::nullopt;
}

std::optional<Grown> Exchanges::with_other(
    const Grown& grown, const std::string& out,
    const std::shared_ptr<const EffectDefinition>& in) const {
  const EffectDefinition& leaving = *grown.assessment.model.find(out)->definition;
  const Grown smaller = without(grown, out);
  if (!may_take_the_place(*in, leaving) || is_another(*in, leaving, smaller)) return std::nullopt;
  const bool like =
      stands_for(leaving, *in) && effects::camera_of(in->name) == effects::camera_of(out);
  if (!has_place(*in, smaller.assessment.model)) return std::nullopt;
  return *tried_.of(0, key_of(problem_, grown, {out, in->name + "\n" + in->source}), [&] {
    std::optional<Grown> other;
    if (like) {
      other = from_its_like(problem_, grown, smaller, in);
    } else if (!is_far_behind(problem_, grown, smaller, in)) {
      std::vector<NotTestable> reasons;
      if (auto candidate = try_effect(problem_, smaller, in, reasons))
        other = std::move(candidate->grown);
    }
    return in_its_place(grown, out, std::move(other));
  });
}

}  // namespace seam::measurement
