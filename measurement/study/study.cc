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
  explicit Study(const StudyPlan& plan) : plan_(plan) {
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

  StudyResult run(const Jobs& jobs) {
    StudyResult result;
    if (!effect_) result.rows.push_back({.size = kNaN});
    if (effect_ && !plan_.sizes.empty()) {
      const auto sigma = standard_error(jobs);
      result.stopped = !sigma;
      if (!sigma) return result;
      for (const double size : plan_.sizes)
        result.rows.push_back({.size = size, .value = beyond_gap(neutral() + size * *sigma)});
    }
    for (const double value : plan_.values) result.rows.push_back({.size = kNaN, .value = value});
    // One set of each row after the other, so that a study that is stopped, or is made longer
    // later, has as many of each.
    const size_t rows = result.rows.size();
    const uint64_t last = kFirstSet + rows * static_cast<uint64_t>(plan_.seeds);
    std::vector<std::string> told(last - kFirstSet);
    const bool all = jobs(
        kFirstSet, last,
        [&](uint64_t job) {
          const uint64_t number = job - kFirstSet;
          return looked_at(job, result.rows[number % rows].value, plan_.first_seed + number / rows)
              .dump();
        },
        [&](uint64_t job, const std::string& text) { told[job - kFirstSet] = text; });
    result.stopped = !all;
    for (size_t k = 0; k < rows; ++k) {
      std::vector<nlohmann::json> sets;
      for (size_t i = k; i < told.size(); i += rows)
        if (!told[i].empty()) sets.push_back(nlohmann::json::parse(told[i]));
      count(sets, result.rows[k]);
      if (!sets.empty()) result.residuals = sets.back().at("residuals");
    }
    std::erase_if(result.rows, [](const StudyRow& row) { return row.sets == 0; });
    return result;
  }

 private:
  static constexpr uint64_t kStandardError = 0, kFirstSet = 1;  // Numbers of jobs.

  double neutral() const { return effect_->parameters[parameter_].neutral; }
  // At least the least that there is, where a gap lies between it and absent.
  double beyond_gap(double value) const {
    const effects::Parameter& parameter = effect_->parameters[parameter_];
    if (value > neutral()) return std::max(value, parameter.min);
    if (value < neutral()) return std::min(value, parameter.max);
    return value;
  }

  Model truth(double value) const {
    Model model = truth_;
    if (!effect_) return model;
    model.add_neutral(effect_);
    model.set_value(effect_->name, parameter_, value);
    return model;
  }

  std::filesystem::path folder_of(uint64_t job) const {
    return plan_.folder / fmt::format("set-{}", job);
  }

  std::unique_ptr<Problem> made(uint64_t job, const Model& truth, uint64_t seed) const {
    const std::filesystem::path out = folder_of(job);
    std::filesystem::remove_all(out);
    measure_set(truth, MeasurementSet::open(plan_.folder / "protocol"), {.seed = seed, .out = out},
                plan_.instruments);
    disturb_set(plan_.conditions, seed, out);
    return open_problem(out, plan_.instruments);
  }

  // What a fit of the effect's parameters beside the nominal model says of this one's error;
  // nothing where somebody stopped it.
  std::optional<double> standard_error(const Jobs& jobs) {
    if (effect_->spread_only || !std::isfinite(neutral()))
      throw InputError(fmt::format(
          "effect '{}': its detectability is no standard error; give its value", effect_->name));
    std::optional<double> sigma;
    jobs(
        kStandardError, kFirstSet,
        [&](uint64_t) { return nlohmann::json(fitted_standard_error()).dump(); },
        [&](uint64_t, const std::string& text) {
          sigma = nlohmann::json::parse(text).get<double>();
        });
    return sigma;
  }

  double fitted_standard_error() const {
    const auto problem = made(kStandardError, nominal_, plan_.first_seed);
    std::vector<NotTestable> reasons;
    const Grown base{.assessment = assess(*problem, nominal_, refitted_unknowns(nominal_))};
    const auto candidate =
        problem->acts(*effect_) ? try_effect(*problem, base, effect_, reasons) : std::nullopt;
    if (candidate) {
      const Assessment& fitted = candidate->grown.assessment;
      const auto k = index_of(fitted.unknowns, {effect_->name, parameter_});
      if (k && std::isfinite(fitted.fit.sigma[*k])) return fitted.fit.sigma[*k];
    }
    throw InputError(fmt::format("effect '{}': these sets do not tell '{}'{}", effect_->name,
                                 effect_->parameters[parameter_].name,
                                 reasons.empty() ? "" : " (" + reasons.front().why + ")"));
  }

  // A set made, searched and judged.
  nlohmann::json looked_at(uint64_t job, double value, uint64_t seed) const {
    const auto problem = made(job, truth(value), seed);
    const SearchResult result = search(
        *problem, nominal_, {}, [](const std::string&) {}, plan_.material);
    nlohmann::json set = judged(result, value);
    set["seed"] = seed;
    set["residuals"] = problem->facts().scalars();
    set["verdict"] = result.verdict;
    set["steps"] = result.best.added;
    set["error"] = result.best.assessment.error;
    std::filesystem::remove_all(folder_of(job));
    return set;
  }

  static void count(const std::vector<nlohmann::json>& sets, StudyRow& row) {
    double sum = 0, sum2 = 0;
    for (const nlohmann::json& set : sets) {
      const auto tally = [&](Rate& rate, const char* question) {
        if (!set.contains(question)) return;
        rate.hits += set.at(question).get<bool>(), ++rate.trials;
      };
      tally(row.noises, "noises"), tally(row.alarms, "alarm"), tally(row.adds, "adds");
      tally(row.first, "first"), tally(row.exact, "exact"), tally(row.covered, "covered");
      const double error = set.at("error").is_null() ? kNaN : set.at("error").get<double>();
      if (!set.at("as_made").get<bool>())
        row.odd.push_back({.seed = set.at("seed"),
                           .verdict = set.at("verdict"),
                           .steps = set.at("steps"),
                           .error = error});
      sum += error, sum2 += error * error;
      ++row.sets;
    }
    const double n = row.sets;
    row.error = sum / n;
    row.error_sigma =
        n > 1 ? std::sqrt(std::max(0.0, sum2 / n - row.error * row.error) / (n - 1)) : kNaN;
  }

  static const EffectDefinition& definition(const SearchResult& result, const std::string& name) {
    return *result.best.assessment.model.find(name)->definition;
  }

  // What a row counts, where it was asked, and `as_made`: the search ends as the set was made.
  nlohmann::json judged(const SearchResult& result, double value) const {
    nlohmann::json set;
    // Errors that wander in truth and not in the model are no false alarm where a noise names them.
    const bool named = plan_.conditions.wander > 0 && explained_by_noises(result);
    if (plan_.conditions.wander > 0) set["noises"] = named;
    const bool alarm = result.verdict != "adequate" && !named;
    set["alarm"] = alarm;
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
    set["adds"] = added;
    set["as_made"] = !alarm;
    if (hidden_.empty()) return set;
    const auto& candidates = result.first.candidates;
    set["first"] =
        !candidates.empty() && candidates.front().significant &&
        !meant(candidates.front().effect->name, candidates.front().indistinguishable_from).empty();
    const bool exact = result.steps.size() == hidden_.size() && explained.size() == hidden_.size();
    set["exact"] = set["as_made"] = exact;
    if (!effect_) return set;
    const Assessment& best = result.best.assessment;
    if (const auto k = index_of(best.unknowns, {effect_->name, parameter_}))
      set["covered"] = std::abs(best.fit.value[*k] - value) <= 2 * best.fit.sigma[*k];
    return set;
  }

  const StudyPlan& plan_;
  Model nominal_, truth_;
  std::vector<std::string> hidden_;
  std::shared_ptr<const EffectDefinition> effect_;
  size_t parameter_ = 0;
};

}  // namespace

std::string StudyPlan::text() const {
  return nlohmann::json{{"kind", kind},
                        {"effect", effect},
                        {"parameter", parameter},
                        {"hidden", hidden},
                        {"beside", beside},
                        {"material", material},
                        {"conditions", conditions.text()},
                        {"sizes", sizes},
                        {"values", values},
                        {"first_seed", first_seed}}
      .dump();
}

StudyResult study(const StudyPlan& plan, const Jobs& jobs) {
  try {
    return Study(plan).run(jobs);
  } catch (const nlohmann::json::exception& error) {
    throw InputError(fmt::format("a kept result is none of a study: {}", error.what()));
  }
}

}  // namespace seam::measurement
