// What a study found, for people and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "measurement/study/study.h"

namespace seam::measurement {
namespace {

std::string percent(const Rate& rate) {
  if (rate.trials == 0) return "-";
  return fmt::format("{}/{} = {:.0f} % ({:.0f}-{:.0f})", rate.hits, rate.trials, 100 * rate.value(),
                     100 * rate.low(), 100 * rate.high());
}

}  // namespace

std::string study_json(const StudyPlan& plan, const StudyResult& result) {
  const auto rate = [](const Rate& r) {
    return nlohmann::ordered_json{{"hits", r.hits},
                                  {"trials", r.trials},
                                  {"rate", r.value()},
                                  {"low", r.low()},
                                  {"high", r.high()}};
  };
  const auto number = [](double x) {
    return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json json = {
      {"format", "seam-study/1"},  {"kind", plan.kind},     {"effect", plan.effect},
      {"hidden", plan.hidden},     {"beside", plan.beside}, {"conditions", plan.conditions.text()},
      {"material", plan.material}, {"seeds", plan.seeds},   {"residuals", result.residuals}};
  if (result.stopped) json["stopped"] = true;
  json["rows"] = nlohmann::ordered_json::array();
  for (const StudyRow& row : result.rows) {
    nlohmann::ordered_json entry = {{"size", number(row.size)},
                                    {"value", row.value},
                                    {"sets", row.sets},
                                    {"alarms", rate(row.alarms)},
                                    {"adds", rate(row.adds)}};
    if (!plan.effect.empty() || !plan.hidden.empty())
      entry["first"] = rate(row.first), entry["exact"] = rate(row.exact);
    if (!plan.effect.empty()) entry["covered"] = rate(row.covered);
    if (row.noises.trials > 0) entry["noises"] = rate(row.noises);
    entry["error"] = number(row.error), entry["error_sigma"] = number(row.error_sigma);
    entry["odd"] = nlohmann::ordered_json::array();
    for (const OddSet& set : row.odd)
      entry["odd"].push_back({{"seed", set.seed},
                              {"verdict", set.verdict},
                              {"steps", set.steps},
                              {"error", number(set.error)}});
    json["rows"].push_back(std::move(entry));
  }
  return json.dump(1) + "\n";
}

std::string study_text(const StudyPlan& plan, const StudyResult& result) {
  const std::string conditions = plan.conditions.text();
  std::string text = fmt::format(
      "{}: {} sets of {} residuals{}, material {:g}; intervals hold the true rate with 95 %\n",
      plan.kind, plan.seeds, result.residuals, conditions.empty() ? "" : ", " + conditions,
      plan.material);
  if (result.stopped) text += "stopped: what follows is of the sets that were finished\n";
  for (const StudyRow& row : result.rows) {
    if (plan.effect.empty() && plan.hidden.empty()) {
      text += fmt::format("nothing hidden: false alarms {}, effects of the mean {}",
                          percent(row.alarms), percent(row.adds));
    } else if (plan.effect.empty()) {
      text += fmt::format("{}: found {}, first {}, all and no other {}", plan.hidden,
                          percent(row.alarms), percent(row.first), percent(row.exact));
    } else {
      text += fmt::format(
          "{} = {:.5g}{}: found {}, first {}, alone {}, within 2 sigma {}", plan.effect, row.value,
          std::isfinite(row.size) ? fmt::format(" ({:g} sigma)", row.size) : "",
          percent(row.alarms), percent(row.first), percent(row.exact), percent(row.covered));
    }
    if (row.noises.trials > 0) text += fmt::format(", the wandering named {}", percent(row.noises));
    text += fmt::format("; final error {:.4f} +- {:.4f}\n", row.error, row.error_sigma);
    constexpr size_t kMostShown = 10;
    for (size_t i = 0; i < std::min(kMostShown, row.odd.size()); ++i)
      text += fmt::format("  not as made: seed {}, {}: {} (error {:.3f})\n", row.odd[i].seed,
                          row.odd[i].verdict, fmt::join(row.odd[i].steps, ", "), row.odd[i].error);
    if (row.odd.size() > kMostShown)
      text += fmt::format("  ... and {} others (--json)\n", row.odd.size() - kMostShown);
  }
  return text;
}

}  // namespace seam::measurement
