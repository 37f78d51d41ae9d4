#include "tools/workbench/look/prospects.h"

#include <algorithm>
#include <cmath>

#include "measurement/numerics/regression.h"
#include "measurement/report/finite_or_null.h"
#include "measurement/report/report_data.h"
#include "measurement/report/results.h"

namespace seam::tools {

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

json prospect_json(const measurement::Problem& problem, const measurement::Grown& base,
                   const Prospect& prospect, const StepEnd& end, size_t prospects) {
  // What a step gains beside a misfit is as surprising as the same over the noise is without one.
  const double n = static_cast<double>(std::max<size_t>(1, count_used(problem)));
  const double error = base.assessment.error;
  const double misfit = std::max(1.0, error * error - 2 * end.gain_ll / n);
  const auto freedom = static_cast<double>(std::max<size_t>(1, prospect.free.size()));
  const double p_value = std::min(1.0, measurement::chi2_tail(2 * end.gain_ll / misfit, freedom) *
                                           static_cast<double>(prospects));
  const json effects = measurement::effects_json(*prospect.step_to);
  const auto values_of = [&](const std::string& name) {
    return effects.value(name, json::object());
  };
  json fields = {{"effect", prospect.effect->name},
                 {"error", finite_or_null<json>(end.error)},
                 {"gain", finite_or_null<json>(measurement::gain_of(base.assessment, end.error))},
                 {"p_value", p_value},
                 {"significant", p_value < measurement::kCandidateAlarm},
                 {"log_likelihood_gain", finite_or_null<json>(end.gain_ll)},
                 {"parameters", values_of(prospect.effect->name)}};
  for (const auto& companion : prospect.companions)
    fields["with"][companion->name] = values_of(companion->name);
  return fields;
}

}  // namespace seam::tools
