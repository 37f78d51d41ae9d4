// Where fits of servos with torque begin: at what agrees with the accelerations seen.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/servo.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/kinds/joints/motion_look.h"
#include "measurement/kinds/joints/short_runs.h"
#include "measurement/kinds/joints/torque/effort.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Values = std::vector<double>;

constexpr size_t kMostChoices = 24;
// Noise units. A model that misses less is near what moves the joint, whatever that is.
constexpr double kMisses = 2;
constexpr double kNearer = 0.75;  // Of the sum of squares: this much less is nearer.
constexpr double kBrief_s = 0.3, kLonger_s = 1.2;  // Stretches of a log.

// Every choice of one value list of each effect, one after the other; where these are too many, the
// first of each, the second of each, and so on.
std::vector<Values> combinations(const std::vector<std::vector<Values>>& lists) {
  size_t choices = 1, longest = 0;
  for (const auto& list : lists) choices *= list.size(), longest = std::max(longest, list.size());
  if (lists.size() > 2 && choices > kMostChoices) {
    std::vector<Values> some(longest);
    for (size_t i = 0; i < longest; ++i) {
      for (const auto& list : lists) {
        const Values& tail = list[i * list.size() / longest];
        some[i].insert(some[i].end(), tail.begin(), tail.end());
      }
    }
    return some;
  }
  std::vector<Values> all = {{}};
  for (const auto& list : lists) {
    std::vector<Values> longer;
    for (const Values& head : all) {
      for (const Values& tail : list) {
        longer.push_back(head);
        longer.back().insert(longer.back().end(), tail.begin(), tail.end());
      }
    }
    all = std::move(longer);
  }
  return all;
}

bool differs(const Values& a, const Values& b) {
  constexpr double kOther = 0.2;
  for (size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > kOther * std::max(std::abs(a[i]), std::abs(b[i]))) return true;
  }
  return false;
}

// The parameters that a fit may move of effects that are looked for in the motion.
std::vector<Unknown> of_motion(const Model& model, unsigned kind) {
  std::vector<Unknown> unknowns;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effects::start_rule(*effect.definition, kind).search != effects::StartSearch::motion)
      continue;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      if (is_open(effect, i)) unknowns.push_back({effect.definition->name, i});
    }
  }
  return unknowns;
}

// Every two parameters of the motor itself, in either order.
std::vector<std::pair<size_t, size_t>> pairs_of_motor(const Model& model,
                                                      const std::vector<Unknown>& unknowns) {
  const std::string& motor = effects::base_of(model, effects::Base::motor)->definition->name;
  std::vector<std::pair<size_t, size_t>> pairs;
  for (const Unknown& one : unknowns) {
    for (const Unknown& other : unknowns) {
      if (one.effect == motor && other.effect == motor && one.parameter != other.parameter)
        pairs.emplace_back(one.parameter, other.parameter);
    }
  }
  return pairs;
}

// The first parameter times this factor and the second over it; none where their bounds forbid it.
std::optional<Model> traded(const Model& model, std::pair<size_t, size_t> pair, double factor) {
  const effects::ModelEffect& motor = *effects::base_of(model, effects::Base::motor);
  Model other = model;
  for (const auto& [i, by] : {std::pair(pair.first, factor), std::pair(pair.second, 1 / factor)}) {
    const effects::Parameter& parameter = motor.definition->parameters[i];
    const double value = by * motor.parameters[i].value;
    if (!(value > 0) || value < parameter.min || value > parameter.max) return std::nullopt;
    other.set_value(motor.definition->name, i, value);
  }
  return other;
}

// Where a trade costs nothing one way and much the other way, the model stands at the edge of a
// saturation that the runs do not reach: others may ask for a little more, so it goes that way.
Model off_the_edge(const Model& model, const std::vector<Unknown>& unknowns,
                   const std::function<double(const Model&)>& cost_of) {
  constexpr double kAway = 2, kSame = 1e-3;
  const double here = cost_of(model);
  const auto same = [&](const Model& other) { return cost_of(other) <= (1 + kSame) * here; };
  for (const auto& pair : pairs_of_motor(model, unknowns)) {
    const std::optional<Model> away = traded(model, pair, kAway);
    const std::optional<Model> back = traded(model, pair, 1 / kAway);
    if (away && back && same(*away) && !same(*back)) return *away;
  }
  return model;
}

// The model, and with other values of each limit among the unknowns: a limit that is far too low or
// never binds has no slope that leads to its value.
std::vector<Model> with_limits(const Model& model, const std::vector<Unknown>& unknowns) {
  constexpr double kLeast = 0.1, kMost = 300, kNext = 1.3;  // In units of its scale.
  std::vector<Model> models = {model};
  for (const Unknown& unknown : unknowns) {
    const effects::Parameter& parameter =
        model.find(unknown.effect)->definition->parameters[unknown.parameter];
    if (!parameter.fit_reciprocal) continue;
    for (double size = kLeast; size < kMost; size *= kNext) {
      models.push_back(model);
      models.back().set_value(unknown.effect, unknown.parameter, size * parameter.scale);
    }
  }
  return models;
}

struct Side {
  Model model;
  double cost;
};

// Descends on the accelerations from the model, and from the other side of a saturation: a motor's
// strength and its controller's gain act as a product, and are told apart only where something
// saturates; no descent crosses from one side of that to the other.
std::vector<Side> both_sides(const MotionLook& look, const Model& model,
                             const std::vector<Unknown>& unknowns) {
  constexpr double kAcross = 8;
  std::optional<Model> across;
  double cheapest = std::numeric_limits<double>::infinity();
  for (const auto& pair : pairs_of_motor(model, unknowns)) {
    const std::optional<Model> there = traded(model, pair, kAcross);
    if (!there) continue;
    for (Model& limited : with_limits(*there, unknowns)) {
      const double cost = look.cost(limited);
      if (cost < cheapest) cheapest = cost, across = std::move(limited);
    }
  }
  std::vector<Side> sides = {{model, 0}};
  if (across) sides.push_back({*across, 0});
  for (Side& side : sides) side.cost = look.descend(side.model, unknowns);
  return sides;
}

// The side that agrees best with accelerations, where short stretches say that it is better than
// the start, and the one that agrees best with these, where it is another.
std::vector<Model> worth_descending(const Model& start, const std::vector<Side>& sides,
                                    const ShortRuns& brief) {
  const auto seen = std::min_element(sides.begin(), sides.end(),
                                     [](const Side& a, const Side& b) { return a.cost < b.cost; });
  const Model* closest = &start;
  double lowest = brief.cost(start);
  std::vector<Model> worth = {brief.cost(seen->model) < lowest ? seen->model : start};
  for (const Side& side : sides) {
    const double cost = brief.cost(side.model);
    if (cost < lowest) lowest = cost, closest = &side.model;
  }
  const bool other = closest != &seen->model && closest != &start;
  if (other) worth.push_back(*closest);
  return worth;
}

// Where a descent on the accelerations ended, and what it misses of these and of short stretches.
struct Descended {
  double by_accelerations = 0, by_stretches = 0;
  Values values;
};

// The best by short stretches, then the best by accelerations where it is another, or else the next
// by stretches: a motor that does nothing misses no acceleration of a joint that rests for most of
// its time.
std::vector<Values> best_by_both(std::vector<Descended> found) {
  constexpr size_t kMostStarts = 2;
  std::stable_sort(found.begin(), found.end(), [](const Descended& a, const Descended& b) {
    return a.by_stretches < b.by_stretches;
  });
  const auto seen =
      std::min_element(found.begin(), found.end(), [](const Descended& a, const Descended& b) {
        return a.by_accelerations < b.by_accelerations;
      });
  std::rotate(found.begin() + (seen != found.begin()), seen, seen + 1);
  std::vector<Values> starts;
  for (const Descended& one : found) {
    if (starts.empty() || (starts.size() < kMostStarts && differs(starts.front(), one.values)))
      starts.push_back(one.values);
  }
  return starts;
}

}  // namespace

// A drive is cut off by a limit, or by a duty that saturates: the same at rest, and a valley apart,
// since back-EMF acts outside the one and inside the other.
std::vector<Model> cut_off_otherwise(const Model& model, const std::vector<Unknown>& unknowns) {
  constexpr double kFarFromSaturation = 8;
  std::vector<Model> others;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *model.find(unknown.effect);
    const effects::Parameter& parameter = effect.definition->parameters[unknown.parameter];
    if (!parameter.fit_reciprocal) continue;
    const double limit = effect.parameters[unknown.parameter].value;
    for (const auto& pair : pairs_of_motor(model, unknowns)) {
      const double strength =
          effects::base_of(model, effects::Base::motor)->parameters[pair.first].value;
      const double by = limit < strength ? limit / strength : kFarFromSaturation;
      std::optional<Model> other = traded(model, pair, by);
      if (!other) continue;
      other->set_value(unknown.effect, unknown.parameter,
                       limit < strength ? parameter.neutral : strength);
      others.push_back(std::move(*other));
    }
  }
  return others;
}

// Where a motor saturates for moments alone, trades cost nothing from the side where nothing does
// until they reach these: no slope leads there.
std::optional<Model> trade_that_helps(const Model& model, const std::vector<Unknown>& unknowns,
                                      const std::function<double(const Model&)>& misfit_of) {
  constexpr double kFactor = 1.1, kFarthest = 10, kWorse = 1.1, kHelps = 0.995;
  const double here = misfit_of(model);
  double least = kHelps * here;
  std::optional<Model> best;
  for (const auto& pair : pairs_of_motor(model, unknowns)) {
    for (double factor = kFactor; factor < kFarthest; factor *= kFactor) {
      std::optional<Model> there = traded(model, pair, factor);
      const double misfit = there ? misfit_of(*there) : std::numeric_limits<double>::infinity();
      if (!(misfit < kWorse * here)) break;
      if (misfit < least) least = misfit, best = std::move(there);
    }
  }
  return best;
}

std::vector<char> JointsProblem::logs_of(const Groups& groups) const {
  std::vector<char> chosen;
  for (const JointLog& log : set_.logs) chosen.push_back(groups[facts_.group_of_row[log.rows[0]]]);
  return chosen;
}

MotionLook JointsProblem::motion_look(const Model& model, const std::vector<char>& chosen) const {
  const bool without_friction = !effects::has_dry_friction(effects::servo_of(model).torque);
  return MotionLook(set_, chosen, facts_.channels[0].noise, without_friction);
}

// Over stretches that each begin where the joint was seen, a motor with all that acts beside it
// comes nearer than the model at hand; where it does not, fits of whole runs would be in vain. True
// also where the model misses too little to say.
bool JointsProblem::shows_torque(const Model& model, Model motor, const Groups& groups) const {
  if (!(misfit_under(*this, model, groups) > kMisses)) return true;
  const std::vector<char> chosen = logs_of(groups);
  for (const auto& effect : effects::catalogue()) {
    const auto& rule = effects::start_rule(*effect, facts_.set.kind);
    const bool beside = effect->needs_base == effects::Base::motor && !motor.has(effect->name);
    if (!beside || rule.search != effects::StartSearch::motion || !acts(*effect) ||
        effects::is_excluded(*effect, motor))
      continue;
    motor.add_neutral(effect);
    for (size_t i = 0; i < effect->parameters.size(); ++i)
      motor.set_value(effect->name, i, rule.values.front()[i]);
  }
  const std::vector<Unknown> unknowns = of_motion(motor, facts_.set.kind);
  const ShortRuns stretches(set_, chosen, kLonger_s);
  const double enough = kNearer * stretches.cost(model);
  std::vector<Side> sides = both_sides(motion_look(motor, chosen), motor, unknowns);
  return std::any_of(sides.begin(), sides.end(), [&](const Side& side) {
    return stretches.cost(side.model) < enough ||
           stretches.cost(stretches.descend(side.model, unknowns)) < enough;
  });
}

std::vector<Values> JointsProblem::starts_together(const Model& model,
                                                   const EffectDefinition& effect,
                                                   const EffectList& companions) const {
  if (effects::start_rule(effect, facts_.set.kind).search != effects::StartSearch::motion)
    return starts(model, effect);
  EffectList moved = {std::make_shared<EffectDefinition>(effect)};
  moved.insert(moved.end(), companions.begin(), companions.end());
  std::vector<std::vector<Values>> lists;
  Model base = model;
  effects::remove_replaced(effect, base);
  // What stands in the model already gives way.
  std::vector<Unknown> unknowns = of_motion(base, facts_.set.kind);
  for (const auto& definition : moved) {
    lists.push_back(effects::start_rule(*definition, facts_.set.kind).values);
    base.add_neutral(definition);
    for (size_t i = 0; i < definition->parameters.size(); ++i) {
      if (is_open(*base.find(definition->name), i)) unknowns.push_back({definition->name, i});
    }
  }
  const Groups training = folds().size() == 1 ? training_groups() : all_groups();
  const std::vector<char> chosen = logs_of(training);
  const std::vector<Values> begun = combinations(lists);
  const auto beginning = [&](const Values& values) {
    Model trial = base;
    size_t at = 0;
    for (const auto& definition : moved) {
      for (size_t i = 0; i < definition->parameters.size(); ++i)
        trial.set_value(definition->name, i, values[at++]);
    }
    return trial;
  };
  const MotionLook look = motion_look(beginning(begun.back()), chosen);
  const ShortRuns brief(set_, chosen, kBrief_s);
  std::vector<Descended> found(begun.size());
  parallel_for(begun.size(), [&](size_t c) {
    Model trial = beginning(begun[c]);
    // The coarse look of the motor itself is on all sides already.
    if (effect.base == effects::Base::motor) {
      found[c].by_accelerations = look.descend(trial, unknowns);
    } else {
      std::vector<Side> sides = both_sides(look, trial, unknowns);
      Side& best = *std::min_element(sides.begin(), sides.end(),
                                     [](const Side& a, const Side& b) { return a.cost < b.cost; });
      found[c].by_accelerations = best.cost, trial = std::move(best.model);
    }
    for (const auto& definition : moved) {
      const auto list = trial.find(definition->name)->values();
      found[c].values.insert(found[c].values.end(), list.begin(), list.end());
    }
    found[c].by_stretches = brief.cost(trial);
  });
  const double least =
      std::min_element(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return a.by_stretches < b.by_stretches;
      })->by_stretches;
  std::vector<Values> starts = best_by_both(std::move(found));
  if (effect.base == effects::Base::motor && !(least < kNearer * brief.cost(model)) &&
      !shows_torque(model, beginning(starts.front()), training))
    return {};
  if (companions.empty()) {
    if (auto limit = limit_that_helps(base, effect, training))
      starts = {{*limit}, std::move(starts.front())};
  }
  return starts;
}

Model JointsProblem::near_start(const Model& start, const std::vector<Unknown>& unknowns,
                                const Groups& groups) const {
  constexpr double kFar = 10;  // Noise units: nothing is explained yet.
  const auto cost_of = [&](const Model& model) { return misfit_under(*this, model, groups); };
  std::vector<Unknown> means;
  for (const Unknown& unknown : unknowns) {
    const EffectDefinition& effect = *start.find(unknown.effect)->definition;
    if (!effect.spread_only && !is_of_efforts(effect)) means.push_back(unknown);
  }
  Model best = start;
  double least = cost_of(start);
  if (least >= kFar) {
    const std::vector<char> chosen = logs_of(groups);
    const ShortRuns brief(set_, chosen, kBrief_s), longer(set_, chosen, kLonger_s);
    const MotionLook look = motion_look(start, chosen);
    for (const Model& side : worth_descending(start, both_sides(look, start, means), brief)) {
      Model here = side;
      for (const ShortRuns* stretches : {&brief, &longer}) {
        here = stretches->descend(here, means);
        const double cost = cost_of(here);
        if (cost < least) least = cost, best = here;
      }
    }
  }
  return off_the_edge(best, means, cost_of);
}

}  // namespace seam::measurement
