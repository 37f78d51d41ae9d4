#include "measurement/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "effects/registry.h"
#include "measurement/kinds/kinds.h"
#include "measurement/search/order.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// One study: the protocol, the nominal model, and the effect that is hidden.
class Study {
 public:
  Study(const StudyPlan& plan, const Progress& progress) : plan_(plan), progress_(progress) {
    nominal_ = write_study_protocol(plan.kind, plan.folder / "protocol");
    arrange_protocol(plan.conditions, plan.folder / "protocol");
    const auto several = [&](const std::string& text, Model into) {
      if (text.empty()) return into;
      const Model more = Model::from_config(ConfigNode::from_text(
          "format: seam-model/1\neffects: " + text + "\n", "effects of the study"));
      for (const effects::ModelEffect& effect : more.effects())
        into.set(effect.definition, effect.parameters);
      return into;
    };
    nominal_ = several(plan.beside, nominal_);
    truth_ = several(plan.hidden, nominal_);
    for (const effects::ModelEffect& effect : truth_.effects()) {
      if (!nominal_.has(effect.definition->name)) hidden_.push_back(effect.definition->name);
    }
    if (plan.effect.empty()) return;
    effect_ = effects::find_effect(plan.effect);
    if (!effect_)
      throw InputError(fmt::format("unknown effect '{}'{}", plan.effect,
                                   suggestion_for(plan.effect, effects::effect_names())));
    const auto& all = effect_->parameters;
    const auto found = std::find_if(all.begin(), all.end(), [&](const effects::Parameter& p) {
      return plan.parameter.empty() || p.name == plan.parameter;
    });
    if (found == all.end()) {
      std::vector<std::string> names;
      for (const effects::Parameter& p : all) names.push_back(p.name);
      throw InputError(fmt::format("effect '{}' has no parameter '{}'{}", plan.effect,
                                   plan.parameter, suggestion_for(plan.parameter, names)));
    }
    parameter_ = static_cast<size_t>(found - all.begin());
    hidden_ = {plan.effect};
  }

  StudyResult run() {
    StudyResult result;
    const auto look = [&](double size, double value) {
      StudyRow row = at(size, value);
      if (row.sets > 0) result.rows.push_back(row);
    };
    if (!effect_) look(kNaN, 0);
    if (effect_ && !plan_.sizes.empty()) {
      const double sigma = standard_error();
      for (const double size : plan_.sizes) look(size, neutral() + size * sigma);
    }
    for (const double value : plan_.values) look(kNaN, value);
    result.residuals = residuals_;
    result.stopped = stopped_;
    return result;
  }

 private:
  bool stopped() { return stopped_ = stopped_ || plan_.stopped(); }

  double neutral() const { return effect_->parameters[parameter_].neutral; }

  Model truth(double value) const {
    Model model = truth_;
    if (!effect_) return model;
    model.add_neutral(effect_);
    model.set_value(effect_->name, parameter_, value);
    return model;
  }

  std::unique_ptr<Problem> made(const Model& truth, uint64_t seed) {
    const std::filesystem::path out = plan_.folder / "set";
    std::filesystem::remove_all(out);
    measure_set(truth, MeasurementSet::open(plan_.folder / "protocol"), {.seed = seed, .out = out},
                plan_.instruments);
    disturb_set(plan_.conditions, seed, out);
    auto problem = open_problem(out, plan_.instruments);
    residuals_ = problem->facts().scalars();
    return problem;
  }

  // What a fit of the effect's parameters beside the nominal model says of this one's error.
  double standard_error() {
    if (effect_->spread_only || !std::isfinite(neutral()))
      throw InputError(fmt::format(
          "effect '{}': its detectability is no standard error; give its value", effect_->name));
    const auto problem = made(nominal_, plan_.first_seed);
    std::vector<NotTestable> reasons;
    const Grown base{.assessment = assess(*problem, nominal_, refitted_unknowns(nominal_))};
    const auto candidate =
        problem->acts(*effect_) ? try_effect(*problem, base, effect_, reasons) : std::nullopt;
    if (candidate) {
      const Assessment& fitted = candidate->grown.assessment;
      for (size_t k = 0; k < fitted.unknowns.size(); ++k) {
        const Unknown& unknown = fitted.unknowns[k];
        if (unknown.effect == effect_->name && unknown.parameter == parameter_ &&
            std::isfinite(fitted.fit.sigma[k]))
          return fitted.fit.sigma[k];
      }
    }
    throw InputError(fmt::format("effect '{}': these sets do not tell '{}'{}", effect_->name,
                                 effect_->parameters[parameter_].name,
                                 reasons.empty() ? "" : " (" + reasons.front().why + ")"));
  }

  StudyRow at(double size, double value) {
    StudyRow row{.size = size, .value = value};
    double sum = 0, sum2 = 0;
    const std::string what =
        effect_ ? fmt::format("{} = {:.4g}", plan_.effect, value) : "nothing hidden";
    for (int i = 0; i < plan_.seeds && !stopped(); ++i) {
      progress_(fmt::format("{}, {}: set {} of {}", plan_.kind, what, i + 1, plan_.seeds));
      const auto problem = made(truth(value), plan_.first_seed + static_cast<uint64_t>(i));
      const SearchResult result = search(
          *problem, nominal_, {}, [](const std::string&) {}, plan_.material);
      const double error = result.best.assessment.error;
      if (!count(result, value, row))
        row.odd.push_back({.seed = plan_.first_seed + static_cast<uint64_t>(i),
                           .verdict = result.verdict,
                           .steps = result.best.added,
                           .error = error});
      sum += error, sum2 += error * error;
      ++row.sets;
    }
    const double n = row.sets;
    row.error = sum / n;
    row.error_sigma =
        n > 1 ? std::sqrt(std::max(0.0, sum2 / n - row.error * row.error) / (n - 1)) : kNaN;
    return row;
  }

  static const EffectDefinition& definition(const SearchResult& result, const std::string& name) {
    return *result.best.assessment.model.find(name)->definition;
  }

  // Whether the search ends as the set was made.
  bool count(const SearchResult& result, double value, StudyRow& row) const {
    const auto tally = [](Rate& rate, bool hit) {
      rate.hits += hit, ++rate.trials;
      return hit;
    };
    // Errors that wander in truth and not in the model are no false alarm where a noise names them.
    const bool named = plan_.conditions.wander > 0 && explained_by_noises(result);
    if (plan_.conditions.wander > 0) tally(row.noises, named);
    const bool found = tally(row.alarms, result.verdict != "adequate" && !named);
    const auto is_hidden = [&](const std::string& name) {
      return std::find(hidden_.begin(), hidden_.end(), name) != hidden_.end();
    };
    // The hidden effect that a name, or one of its declared ties, stands for; empty: none.
    const auto meant = [&](const std::string& name, const std::vector<std::string>& ties) {
      if (is_hidden(name)) return name;
      const auto tie = std::find_if(ties.begin(), ties.end(), is_hidden);
      return tie == ties.end() ? std::string() : *tie;
    };
    bool added = false;
    std::set<std::string> explained;
    for (const Step& step : result.steps) {
      const std::string name = meant(step.effect, step.indistinguishable_from);
      added = added || (name.empty() && !definition(result, step.effect).spread_only);
      if (!name.empty()) explained.insert(name);
    }
    tally(row.adds, added);
    if (hidden_.empty()) return !found;
    const auto& candidates = result.first.candidates;
    tally(row.first,
          !candidates.empty() && candidates.front().significant &&
              !meant(candidates.front().effect->name, candidates.front().indistinguishable_from)
                   .empty());
    const bool exact = tally(
        row.exact, result.steps.size() == hidden_.size() && explained.size() == hidden_.size());
    if (!effect_) return exact;
    const Assessment& best = result.best.assessment;
    for (size_t k = 0; k < best.unknowns.size(); ++k) {
      if (best.unknowns[k].effect == effect_->name && best.unknowns[k].parameter == parameter_)
        tally(row.covered, std::abs(best.fit.value[k] - value) <= 2 * best.fit.sigma[k]);
    }
    return exact;
  }

  const StudyPlan& plan_;
  const Progress& progress_;
  Model nominal_, truth_;
  std::vector<std::string> hidden_;
  std::shared_ptr<const EffectDefinition> effect_;
  size_t parameter_ = 0;
  size_t residuals_ = 0;
  bool stopped_ = false;
};

double wilson(int hits, int trials, double side) {
  if (trials == 0) return side > 0 ? 1 : 0;
  constexpr double z = 1.959964;
  const double n = trials, p = hits / n, z2n = z * z / n;
  const double middle = p + 0.5 * z2n, reach = z * std::sqrt(p * (1 - p) / n + 0.25 * z2n / n);
  return std::clamp((middle + side * reach) / (1 + z2n), 0.0, 1.0);
}

std::string percent(const Rate& rate) {
  if (rate.trials == 0) return "-";
  return fmt::format("{}/{} = {:.0f} % ({:.0f}-{:.0f})", rate.hits, rate.trials, 100 * rate.value(),
                     100 * rate.low(), 100 * rate.high());
}

}  // namespace

double Rate::low() const {
  return wilson(hits, trials, -1);
}
double Rate::high() const {
  return wilson(hits, trials, 1);
}

StudyResult study(const StudyPlan& plan, const Progress& progress) {
  return Study(plan, progress).run();
}

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
