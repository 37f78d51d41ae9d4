#include "measurement/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/registry.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/regression.h"
#include "measurement/plan/planned_value.h"
#include "sim_core/base/error.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Sizes are sought up to so many times the size tried; an effect that needs more has its bounds.
constexpr double kMostScale = 1e4;

// Parts of a plan without linear columns, in words that follow a name.
std::string why_not_planned(const Prospect& prospect, const Facts& facts, bool by_likelihood) {
  const EffectDefinition& effect = *prospect.effect;
  if (effect.draws_estimated) return "its draws are estimated with it: seam study";
  if (has_counts(effect))
    return "its parameter is a whole number, which is tried and not fitted: seam study";
  if (!effect.has_neutral) return "it replaces another effect: seam study";
  if (!prospect.companions.empty())
    return "it needs " + prospect.companions.front()->name + ": plan with a model that has it";
  if (by_likelihood && effect.spread_only)
    return "what it gains is no square of its size: seam study";
  using effects::StartSearch;
  const StartSearch search = effects::start_rule(effect, facts.set.kind).search;
  if (by_likelihood && search != StartSearch::slope && search != StartSearch::listed)
    return "its fit begins where the data lead it: seam study";
  if (prospect.starts.size() > kMostStartsOfOneValley)
    return "its fit has several local optima: seam study";
  return "";
}

}  // namespace

double PairGains::repeats_to_part() const {
  constexpr double kMost = 1e4;
  const auto tied = [&](double by) { return cannot_tell(truth * by, other * by, 1); };
  if (tied(kMost) || other >= truth) return kInfinity;
  double low = 0, high = kMost;
  while (high - low > 1e-3 * high) {
    const double middle = 0.5 * (low + high);
    (tied(middle) ? low : high) = middle;
  }
  return high;
}

Planner::Planner(Problem& problem, const Model& model, const PlanOptions& options)
    : problem_(problem), options_(options) {
  problem.prepare(model);
  problem.check_model(model);
  base_.assessment = assess_fixed(problem, model);
  base_.assessment.unknowns = refitted_unknowns(model);
  here_ = problem.evaluate(model, problem.all_groups());
  by_likelihood_ = here_.whitened.empty();
  // Photon noise depends on the gain, too.
  std::erase_if(base_.assessment.unknowns, [&](const Unknown& unknown) {
    return !by_likelihood_ && model.find(unknown.effect)->definition->spread_only;
  });
  if (!here_.valid && !by_likelihood_)
    throw InputError(
        problem.facts().file +
        ": the model predicts no value for some rows of this protocol: expected one for each");
  const auto near = start_of_prospects(problem, model, &here_);
  const EffectList absent = absent_effects(problem, model, {});
  std::vector<std::optional<Prospect>> prospects(absent.size());
  std::vector<std::vector<NotTestable>> reasons(absent.size());
  {
    const Work work("effects looked at", absent.size());
    parallel_for(absent.size(), [&](size_t i) {
      prospects[i] = prospect_of(problem, base_, absent[i], reasons[i], /*alone=*/false,
                                 near ? &*near : nullptr);
      work.done();
    });
  }
  for (size_t i = 0; i < absent.size(); ++i) {
    looks_ += prospects[i].has_value();
    not_testable_.insert(not_testable_.end(), reasons[i].begin(), reasons[i].end());
    if (prospects[i]) see(*prospects[i]);
  }
  parallel_for(seen_.size(), [&](size_t i) {
    Seen& seen = seen_[i];
    if (by_likelihood_ || !seen.why_not.empty()) return;
    const Evaluation there = problem.evaluate(seen.probe, problem.all_groups(), &here_);
    seen.columns = columns_of(seen, seen.probe, there, seen.why_not);
  });
}

Columns Planner::columns_of(const Seen& seen, const Model& model, const Evaluation& there,
                            std::string& why) const {
  Columns columns;
  if (there.valid && seen.effect->spread_only) {
    if (!errors_are_independent(problem_, here_) || !errors_are_independent(problem_, there)) {
      why = "with it errors are not independent of each other: seam study";
      return columns;
    }
    columns = spread_columns_at(problem_, model, seen.unknowns);
  } else if (there.valid) {
    columns = columns_at(problem_, model, seen.unknowns, there);
  }
  if (columns.by.empty() || columns.by.front().empty())
    why = "the model predicts no value for some rows with it";
  return columns;
}

Planner Planner::repeated(double times) const {
  Planner more = *this;
  more.repeats_ *= times;
  return more;
}

void Planner::see(const Prospect& prospect) {
  Seen seen{.effect = prospect.effect,
            .free = prospect.free,
            .probe = base_.assessment.model,
            .unknowns = base_.assessment.unknowns,
            .why_not = why_not_planned(prospect, problem_.facts(), by_likelihood_)};
  // Spreads are estimated from the sizes of residuals, which values of the mean do not change.
  if (prospect.effect->spread_only) seen.unknowns.clear();
  if (seen.why_not.empty()) {
    seen.probe.add_neutral(prospect.effect);
    for (const size_t i : prospect.free) {
      seen.probe.set_value(prospect.effect->name, i, prospect.starts.front()[i]);
      seen.unknowns.push_back({prospect.effect->name, i});
    }
  }
  seen_.push_back(std::move(seen));
}

const Planner::Seen& Planner::seen(const std::string& name) const {
  const auto found = find(name);
  if (found == nullptr || !found->why_not.empty())
    throw InputError(fmt::format("{}: no plan for it: {}", name, why_not(name)));
  return *found;
}

const Planner::Seen* Planner::find(const std::string& name) const {
  const auto found = std::find_if(seen_.begin(), seen_.end(),
                                  [&](const Seen& s) { return s.effect->name == name; });
  return found == seen_.end() ? nullptr : &*found;
}

std::string Planner::why_not(const std::string& name) const {
  if (const Seen* found = find(name)) return found->why_not;
  if (base_.assessment.model.has(name)) return "the model has it already";
  for (const NotTestable& n : not_testable_) {
    if (n.effect == name) return n.why;
  }
  return "it does not act on this set beside this model";
}

Planner::Sized Planner::sized(const Seen& seen, size_t parameter) const {
  const Coordinate coordinate(seen.probe, {seen.effect->name, parameter});
  const double neutral = neutral_of(coordinate);
  const double least = coordinate.min - neutral, most = coordinate.max - neutral;
  double away = coordinate.of(seen.probe) - neutral;
  if (away == 0) away = most > 0 ? 0.05 * coordinate.scale : -0.05 * coordinate.scale;
  Sized out{.parameter = {.name = coordinate.parameter->name, .sigma = kInfinity}};
  // What an effect moves grows with its size, or with a power of it; a step follows that power.
  double power = 1, last_away = 0, last_scale = 0;
  constexpr int kMostSteps = 6;
  constexpr double kGoodTo = 0.02;
  for (int step = 0; step < kMostSteps; ++step) {
    const auto there = moved(seen, parameter, away);
    if (!there) return out;
    out.parameter.sigma = there->sigma;
    const double scale = Detection(there->look).scale_found(kMostScale);
    if (!std::isfinite(scale)) return out;
    // The least that there is, where a gap lies between it and absent.
    const bool least_of_all = scale < 1 && away == (away > 0 ? least : most);
    if (std::abs(scale - 1) < kGoodTo || least_of_all || step + 1 == kMostSteps) {
      out.shift = there->shift, out.gain = gain_of(there->look.whole(), base_columns(seen));
      out.parameter.smallest_found =
          std::abs(coordinate.to_value(neutral + away) -
                   (coordinate.parameter->fit_reciprocal ? 0 : coordinate.parameter->neutral));
      return out;
    }
    if (last_away != 0 && away != last_away)
      power = std::clamp(-std::log(scale / last_scale) / std::log(away / last_away), 0.5, 4.0);
    last_away = away, last_scale = scale;
    const double wished = away * std::pow(scale, 1 / power);
    away = std::clamp(wished, least, most);
    if (away == last_away) return out;  // At a bound, where it is not found.
  }
  return out;
}

double Planner::gain_beside(const Seen& other, const std::vector<double>& shift) const {
  const EffectLook look =
      look_of(problem_, here_, other.columns, shift, base_columns(other), repeats_);
  return gain_of(look.whole(), base_columns(other));
}

std::vector<PlannedTie> Planner::ties_of(const Seen& seen, const Sized& sized) const {
  std::vector<PlannedTie> ties;
  if (sized.shift.empty()) return ties;
  PairGains pair{.truth = sized.gain};
  for (const Seen& other : seen_) {
    if (&other == &seen || !other.why_not.empty() ||
        other.effect->spread_only != seen.effect->spread_only)
      continue;
    pair.other = gain_beside(other, sized.shift);
    if (!cannot_tell(pair.truth, pair.other, 1)) continue;
    PlannedTie tie{.effect = other.effect->name};
    // Gains grow with the square of a size, and with the number of sets.
    const double repeats = pair.repeats_to_part();
    if (std::isfinite(repeats))
      tie.apart_from = *sized.parameter.smallest_found * std::sqrt(std::max(1.0, repeats));
    ties.push_back(std::move(tie));
  }
  return ties;
}

PairGains Planner::gains(const std::string& effect, double size, const std::string& other) const {
  const Seen& true_one = seen(effect);
  const Seen& other_one = seen(other);
  const bool alike = true_one.effect->spread_only == other_one.effect->spread_only;
  const size_t parameter = true_one.free.front();
  const Coordinate coordinate(true_one.probe, {effect, parameter});
  const double neutral = neutral_of(coordinate);
  const bool up = coordinate.of(true_one.probe) >= neutral;
  const double to = coordinate.parameter->fit_reciprocal ? 1 / size : (up ? size : -size);
  const auto there = moved(true_one, parameter, to);
  if (!there) return {};
  return {.truth = gain_of(there->look.whole(), base_columns(true_one)),
          .other = alike ? gain_beside(other_one, there->shift) : 0};
}

// Why effects are not planned, one by one, and parameters of those that are.
std::vector<NotTestable> Planner::each_once(const std::vector<NotTestable>& reasons,
                                            const std::vector<const Seen*>& planned) {
  std::vector<NotTestable> listed;
  for (const NotTestable& reason : reasons) {
    const bool is_planned = std::ranges::any_of(
        planned, [&](const Seen* seen) { return seen->effect->name == reason.effect; });
    const auto same = std::ranges::find_if(listed, [&](const NotTestable& other) {
      return other.effect == reason.effect && other.parameter.empty();
    });
    if (is_planned || same == listed.end()) {
      listed.push_back({reason.effect, is_planned ? reason.parameter : "", reason.why});
    } else if (same->why.find(reason.why) == std::string::npos) {
      same->why += "; " + reason.why;
    }
  }
  return listed;
}

void Planner::look_at(const std::vector<const Seen*>& planned, Plan& plan) const {
  const size_t first = plan.effects.size();
  plan.effects.resize(first + planned.size());
  const Work work("effects planned", planned.size());
  parallel_for(planned.size(), [&](size_t i) {
    PlannedEffect& out = plan.effects[first + i];
    out.effect = planned[i]->effect->name;
    std::optional<Sized> at;
    for (const size_t parameter : planned[i]->free) {
      Sized sized = this->sized(*planned[i], parameter);
      out.parameters.push_back(sized.parameter);
      if (!at && !sized.shift.empty()) at = std::move(sized);
    }
    if (at) out.ties = ties_of(*planned[i], *at);
    work.done();
  });
}

Plan Planner::plan() const {
  Plan plan{.residuals = count_used(problem_),
            .groups = problem_.facts().groups.size(),
            .has_ties = !by_likelihood_,
            .looks = looks_};
  const std::vector<std::string>& asked = options_.effects;
  const auto wanted = [&](const std::string& name) {
    return asked.empty() || std::find(asked.begin(), asked.end(), name) != asked.end();
  };
  for (const effects::ModelEffect& effect : base_.assessment.model.effects()) {
    if (!wanted(effect.definition->name)) continue;
    PlannedEffect own = of_model(effect.definition->name);
    if (!own.parameters.empty()) {
      plan.effects.push_back(std::move(own));
    } else if (!asked.empty()) {
      plan.not_planned.push_back(
          {own.effect, "", "the model has it, with no free parameter: mark one as free"});
    }
  }
  std::vector<const Seen*> planned;
  for (const Seen& one : seen_) {
    if (!wanted(one.effect->name)) continue;
    if (one.why_not.empty()) {
      planned.push_back(&one);
    } else {
      plan.not_planned.push_back({one.effect->name, "", one.why_not});
    }
  }
  for (NotTestable& n : each_once(not_testable_, planned)) {
    const Seen* seen = find(n.effect);
    const bool said = seen != nullptr && !seen->why_not.empty();
    if (wanted(n.effect) && !said) plan.not_planned.push_back(std::move(n));
  }
  for (const std::string& name : asked) {
    const bool listed = std::any_of(plan.not_planned.begin(), plan.not_planned.end(),
                                    [&](const NotTestable& n) { return n.effect == name; });
    if (!listed && find(name) == nullptr && !base_.assessment.model.has(name))
      plan.not_planned.push_back({name, "", why_not(name)});
  }
  look_at(planned, plan);
  return plan;
}

}  // namespace seam::measurement
