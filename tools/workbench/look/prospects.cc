#include "tools/workbench/look/prospects.h"

#include <algorithm>
#include <cmath>

#include "measurement/fitting/parameter_space.h"
#include "measurement/numerics/regression.h"
#include "measurement/report/finite_or_null.h"
#include "measurement/report/report_data.h"
#include "measurement/report/results.h"
#include "tools/workbench/look/climb.h"

namespace seam::tools {

using measurement::FewRows;
using measurement::finite_or_null;
using measurement::Prospect;
using measurement::Score;
using nlohmann::json;

std::optional<StepEnd> end_of_step(const measurement::Problem& problem,
                                   const measurement::Grown& base, const Prospect& prospect) {
  if (!prospect.step_to) return std::nullopt;
  const Score all = problem.score(*prospect.step_to, problem.all_groups());
  const double gain = all.log_likelihood - base.assessment.total_ll;
  if (!all.valid || !(gain >= 0)) return std::nullopt;
  const Score held = problem.score_held_out(*prospect.step_to, problem.scored_groups());
  return StepEnd{.gain_ll = gain, .error = held.error()};
}

std::vector<size_t> most_promising_first(const Prospects& prospects,
                                         const std::vector<std::optional<StepEnd>>& ends) {
  std::vector<size_t> order;
  for (size_t i = 0; i < prospects.size(); ++i) {
    if (prospects[i]) order.push_back(i);
  }
  const auto class_of = [&](size_t i) {
    return prospects[i]->effect->spread_only ? 2 : ends[i] ? 0 : 1;
  };
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    if (class_of(a) != class_of(b)) return class_of(a) < class_of(b);
    return class_of(a) == 0 && ends[a]->gain_ll > ends[b]->gain_ll;
  });
  return order;
}

std::optional<StepEnd> expected_end(const measurement::Problem& problem,
                                    const measurement::Grown& base, const Prospect& prospect) {
  const double gain = prospect.expected_ll - base.assessment.total_ll;
  if (!prospect.step_to || !std::isfinite(gain) || !(gain > 0)) return std::nullopt;
  const double error = base.assessment.error;
  const double left = error * error - 2 * gain / static_cast<double>(count_used(problem));
  // The gain is of what was before the others' own step, too: it may promise more than there is.
  if (!(left > 0)) return std::nullopt;
  return StepEnd{.gain_ll = gain, .error = std::sqrt(left)};
}

std::optional<FewRows> rows_for_first_sight(const measurement::Problem& problem,
                                            const measurement::Model& model) {
  // 400 residuals of each channel then show what is as large (fitting/few_groups.h).
  constexpr double kPlainAtFirstSight = 0.3;  // Noise units.
  return enough_to_tell(problem, model, problem.training_groups(), kPlainAtFirstSight);
}

namespace {

std::optional<FirstSight> fitted_to_few(const measurement::Problem& problem,
                                        const measurement::Grown& base, Prospect prospect,
                                        const FewRows& few) {
  prospect.few = few;
  std::vector<measurement::NotTestable> reasons;
  const auto seen = fit_prospect(problem, base, prospect, reasons);
  if (!seen) return std::nullopt;
  const measurement::Assessment& there = seen->grown.assessment;
  return FirstSight{
      .model = there.model,
      .end = {.gain_ll = there.total_ll - base.assessment.total_ll, .error = there.error}};
}

// The likeliest of some values of the effect and its companions; the rest of the model stays.
std::optional<FirstSight> best_of_some(const measurement::Problem& problem,
                                       const measurement::Grown& base, const Prospect& prospect) {
  constexpr int kMostLooks = 40;  // Of a millisecond or a few each.
  const auto groups = problem.all_groups();
  const auto height = [&](const measurement::Model& model) {
    const Score score = problem.score(model, groups);
    return score.valid ? score.log_likelihood : -INFINITY;
  };
  std::optional<measurement::Model> start;
  double highest = -INFINITY;
  for (const auto& values : prospect.starts) {
    measurement::Model there = with_effect(base.assessment.model, prospect, values);
    const double here = height(there);
    if (!start || here > highest) start = std::move(there), highest = here;
  }
  if (!start) return std::nullopt;
  std::vector<measurement::Unknown> unknowns;
  for (const size_t i : prospect.free) unknowns.push_back({prospect.effect->name, i});
  const measurement::ParameterSpace space(*start, unknowns);
  const Eigen::VectorXd place = space.place(*start);
  Eigen::VectorXd step(place.size());
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    constexpr double kOfItself = 0.5, kOfItsScale = 0.05;  // What stands at neutral has no size.
    const auto k = static_cast<size_t>(i);
    const double size = std::abs(place[i] - space[k].parameter->neutral);
    step[i] = std::isfinite(size) && size > 0 ? kOfItself * size : kOfItsScale * space[k].scale;
  }
  const Climbed end = climb([&](const Eigen::VectorXd& at) { return height(space.at(*start, at)); },
                            place, step, space.box(), kMostLooks);
  FirstSight seen{.model = space.at(*start, end.place), .end = {}};
  seen.end = {.gain_ll = end.height - base.assessment.total_ll,
              .error = problem.score_held_out(seen.model, problem.scored_groups()).error()};
  return seen;
}

}  // namespace

std::optional<FirstSight> first_sight(const measurement::Problem& problem,
                                      const measurement::Grown& base, const Prospect& prospect,
                                      const std::optional<FewRows>& few) {
  auto seen =
      few ? fitted_to_few(problem, base, prospect, *few) : best_of_some(problem, base, prospect);
  if (!seen || !(seen->end.gain_ll >= 0) || !std::isfinite(seen->end.error)) return std::nullopt;
  return seen;
}

json prospect_json(const measurement::Problem& problem, const measurement::Grown& base,
                   const Prospect& prospect, const measurement::Model& there, const StepEnd& end,
                   size_t prospects) {
  // What a step gains beside a misfit is as surprising as the same over the noise is without one.
  const double n = static_cast<double>(std::max<size_t>(1, count_used(problem)));
  const double error = base.assessment.error;
  const double misfit = std::max(1.0, error * error - 2 * end.gain_ll / n);
  const auto freedom = static_cast<double>(std::max<size_t>(1, prospect.free.size()));
  const double p_value = std::min(1.0, measurement::chi2_tail(2 * end.gain_ll / misfit, freedom) *
                                           static_cast<double>(prospects));
  const json effects = measurement::effects_json(there);
  const auto values_of = [&](const std::string& name) {
    return effects.value(name, json::object());
  };
  json fields = {{"effect", prospect.effect->name},
                 {"error", finite_or_null<json>(end.error)},
                 {"gain", finite_or_null<json>(measurement::gain_of(base.assessment, end.error))},
                 {"p_value", p_value},
                 {"significant", p_value < measurement::kAlarm},
                 {"log_likelihood_gain", finite_or_null<json>(end.gain_ll)},
                 {"parameters", values_of(prospect.effect->name)}};
  for (const auto& companion : prospect.companions)
    fields["with"][companion->name] = values_of(companion->name);
  return fields;
}

}  // namespace seam::tools
