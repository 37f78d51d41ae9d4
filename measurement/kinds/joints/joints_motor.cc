// Fits of servos with torque: whole runs are simulated, smooth in all parameters, from starts that
// agree with the accelerations seen.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <utility>

#include "effects/questions.h"
#include "measurement/fitting/assess.h"
#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/kinds/joints/motion_look.h"
#include "measurement/kinds/joints/short_runs.h"

namespace seam::measurement {
namespace {

using Values = std::vector<double>;

constexpr double kBrief_s = 0.3, kLonger_s = 1.2;  // Stretches of a log.

// Every choice of one value list of each effect, one after the other.
std::vector<Values> combinations(const std::vector<std::vector<Values>>& lists) {
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

// Takes out of a list, over the rows where `part` says so, what a column makes of it.
void take_out(const std::vector<double>& of, std::vector<double>& from,
              const std::vector<size_t>& rows) {
  double along = 0, norm = 0;
  for (const size_t i : rows) along += of[i] * from[i], norm += of[i] * of[i];
  if (!(norm > 0)) return;
  for (const size_t i : rows) from[i] -= along / norm * of[i];
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

// Descends on the accelerations from the model, and from the other side of a saturation: a motor's
// strength and its controller's gain act as a product, and are told apart only where something
// saturates; no descent crosses from one side of that to the other.
double look_around(const MotionLook& look, Model& model, const std::vector<Unknown>& unknowns) {
  constexpr double kAcross = 8;
  std::optional<Model> across;
  double cheapest = std::numeric_limits<double>::infinity();
  for (const auto& pair : pairs_of_motor(model, unknowns)) {
    const std::optional<Model> there = traded(model, pair, kAcross);
    if (!there) continue;
    const double cost = look.cost(*there);
    if (cost < cheapest) cheapest = cost, across = there;
  }
  double least = look.descend(model, unknowns);
  if (!across) return least;
  const double beyond = look.descend(*across, unknowns);
  if (beyond < least) least = beyond, model = *across;
  return least;
}

}  // namespace

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
  std::vector<Unknown> unknowns;
  // What stands in the model already gives way.
  for (const effects::ModelEffect& other : base.effects()) {
    if (effects::start_rule(*other.definition, facts_.set.kind).search !=
        effects::StartSearch::motion)
      continue;
    for (size_t i = 0; i < other.parameters.size(); ++i) {
      if (!other.definition->parameters[i].stated) unknowns.push_back({other.definition->name, i});
    }
  }
  for (const auto& definition : moved) {
    lists.push_back(effects::start_rule(*definition, facts_.set.kind).values);
    base.add_neutral(definition);
    for (size_t i = 0; i < definition->parameters.size(); ++i) {
      if (!definition->parameters[i].stated) unknowns.push_back({definition->name, i});
    }
  }
  const Groups training = folds().size() == 1 ? training_groups() : all_groups();
  std::vector<char> chosen;
  for (const JointLog& log : set_.logs)
    chosen.push_back(training[facts_.group_of_row[log.rows[0]]]);
  const MotionLook look(set_, chosen, facts_.channels[0].noise);
  const std::vector<Values> begun = combinations(lists);
  std::vector<std::pair<double, Values>> found(begun.size());
  parallel_for(begun.size(), [&](size_t c) {
    Model trial = base;
    size_t at = 0;
    for (const auto& definition : moved) {
      for (size_t i = 0; i < definition->parameters.size(); ++i)
        trial.set_value(definition->name, i, begun[c][at++]);
    }
    // The coarse look of the motor itself is on all sides already.
    found[c].first = effect.base == effects::Base::motor ? look.descend(trial, unknowns)
                                                         : look_around(look, trial, unknowns);
    for (const auto& definition : moved) {
      const auto list = trial.find(definition->name)->values();
      found[c].second.insert(found[c].second.end(), list.begin(), list.end());
    }
  });
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  constexpr size_t kMostStarts = 2;
  std::vector<Values> starts;
  for (const auto& [cost, values] : found) {
    if (starts.size() < kMostStarts &&
        std::all_of(starts.begin(), starts.end(),
                    [&, &v = values](const Values& other) { return differs(v, other); }))
      starts.push_back(values);
  }
  return starts;
}

Model JointsProblem::near_start(const Model& start, const std::vector<Unknown>& unknowns,
                                const Groups& groups) const {
  constexpr double kFar = 10;  // Noise units: nothing is explained yet.
  const auto cost_of = [&](const Model& model) {
    const Evaluation there = evaluate(model, groups, nullptr);
    return there.valid ? misfit_of(*this, there) : std::numeric_limits<double>::infinity();
  };
  std::vector<Unknown> means;
  for (const Unknown& unknown : unknowns) {
    if (!start.find(unknown.effect)->definition->spread_only) means.push_back(unknown);
  }
  Model best = start;
  double least = cost_of(start);
  if (least >= kFar) {
    std::vector<char> chosen;
    for (const JointLog& log : set_.logs)
      chosen.push_back(groups[facts_.group_of_row[log.rows[0]]]);
    Model here = start;
    look_around(MotionLook(set_, chosen, facts_.channels[0].noise), here, means);
    const ShortRuns brief(set_, chosen, kBrief_s);
    if (!(brief.cost(here) < brief.cost(start))) here = start;
    const auto offer = [&] {
      const double cost = cost_of(here);
      if (cost < least) least = cost, best = here;
    };
    here = brief.descend(here, means);
    offer();
    here = ShortRuns(set_, chosen, kLonger_s).descend(here, means);
    offer();
  }
  return off_the_edge(best, means, cost_of);
}

// Logs are independent of each other: all their starts are moved at once.
void JointsProblem::take_out_starts(const Model& model, const Groups& groups,
                                    const Evaluation& here, std::vector<Values>& columns) const {
  const double by_rad = here.sigma.empty() ? 0 : facts_.channels[0].noise, by_radps = 0.01;
  const auto slope = [&](double rad, double radps) {
    Evaluation moved;
    moved.nuisance_values = here.nuisance_values, moved.reusable = here.reusable;
    size_t place = 0;
    for (const JointLog& log : set_.logs) {
      if (!groups[facts_.group_of_row[log.rows[0]]]) continue;
      moved.nuisance_values.at(place) += rad;
      if (unknowns_of_start(model, log) > 1) moved.nuisance_values.at(place + 1) += radps;
      place += 2;
    }
    const Evaluation there = evaluate(model, groups, &moved);
    Values column(facts_.scalars(), 0);
    for (size_t i = 0; i < column.size(); ++i) {
      if (here.used[i] && there.valid) column[i] = there.whitened[i] - here.whitened[i];
    }
    return column;
  };
  const Values by_angle = slope(by_rad, 0);
  const bool any_rate = std::any_of(set_.logs.begin(), set_.logs.end(), [&](const JointLog& log) {
    return unknowns_of_start(model, log) > 1;
  });
  Values by_rate = any_rate ? slope(0, by_radps) : Values();
  size_t place = 0;
  for (const JointLog& log : set_.logs) {
    if (!groups[facts_.group_of_row[log.rows[0]]]) continue;
    const double offset_rad = here.nuisance_values.at(place);
    place += 2;
    // A start that is held near where it was measured is not free.
    if (std::abs(offset_rad) >= kFarthestStart * here.sigma[log.rows[0]]) continue;
    if (any_rate) take_out(by_angle, by_rate, log.rows);
    for (Values& column : columns) {
      take_out(by_angle, column, log.rows);
      if (any_rate) take_out(by_rate, column, log.rows);
    }
  }
}

// One-sided differences with the starts of the logs as they are; what these could do about a column
// is taken out of it, so that errors know of them.
std::vector<Values> JointsProblem::motor_jacobian(const Model& model,
                                                  const std::vector<Unknown>& unknowns,
                                                  const Groups& groups,
                                                  const Evaluation& here) const {
  constexpr double kStep = 1e-3;  // Of the parameter's size.
  const ParameterSpace space(model, unknowns);
  std::vector<Values> columns(space.size(), Values(facts_.scalars(), 0));
  parallel_for(space.size(), [&](size_t at) {
    const Coordinate& c = space[at];
    const double z = c.of(model);
    // Two that act as a product alone must move it alike, or the difference of their differences
    // would pass for what the data know of each: those above 0 by their bounds move by their size.
    double step = kStep * (c.min > 0 ? std::abs(z) : std::max(c.scale, std::abs(z)));
    if (z + step > c.max) step = -step;
    Model moved = model;
    c.set(moved, z + step);
    const Evaluation there = evaluate(moved, groups, &here);
    const double slope = std::isfinite(c.slope(z)) ? c.slope(z) : 1;
    for (size_t i = 0; i < columns[at].size(); ++i) {
      if (here.used[i] && there.valid)
        columns[at][i] = (there.whitened[i] - here.whitened[i]) / (step * slope);
    }
  });
  take_out_starts(model, groups, here, columns);
  return columns;
}

}  // namespace seam::measurement
