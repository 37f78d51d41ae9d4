#include "measurement/problem/problem.h"

#include <cmath>
#include <limits>

#include "measurement/sets/set.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

double Score::error() const {
  const double freedom = static_cast<double>(n - nuisances);
  return freedom > 0 ? std::sqrt(chi2 / freedom) : std::numeric_limits<double>::quiet_NaN();
}

std::vector<double> mean_parameters(const Model& model) {
  std::vector<double> key;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effect.definition->spread_only) continue;
    key.push_back(static_cast<double>(std::hash<std::string>{}(effect.definition->name) >> 12));
    for (const double value : effect.values()) key.push_back(value);
  }
  return key;
}

Groups complement(const Groups& groups) {
  Groups other(groups.size());
  for (size_t i = 0; i < groups.size(); ++i) other[i] = !groups[i];
  return other;
}

void whiten_diagonal(const Problem& problem, const Groups& groups, Evaluation& evaluation) {
  const Facts& facts = problem.facts();
  const size_t n = facts.scalars();
  evaluation.used.assign(n, 0);
  evaluation.whitened.assign(n, 0);
  evaluation.log_det.assign(facts.groups.size(), 0);
  for (size_t i = 0; i < n; ++i) {
    const int group = facts.group_of(i);
    if (!groups[group] || problem.left_out(i)) continue;
    evaluation.used[i] = 1;
    evaluation.whitened[i] = evaluation.residual[i] / evaluation.sigma[i];
    evaluation.log_det[group] += 2 * std::log(evaluation.sigma[i]);
  }
}

Score score_of(const Problem& problem, const Evaluation& evaluation) {
  const Facts& facts = problem.facts();
  const double log_two_pi = std::log(2 * maths::kPi);
  Score score;
  score.valid = evaluation.valid;
  score.nuisances = evaluation.nuisances;
  score.by_group.assign(facts.groups.size(), 0);
  score.native_sum2.assign(facts.channels.size(), 0);
  score.native_count.assign(facts.channels.size(), 0);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!evaluation.used[i]) continue;
    const double z2 = evaluation.whitened[i] * evaluation.whitened[i];
    score.chi2 += z2;
    ++score.n;
    score.by_group[facts.group_of(i)] -= 0.5 * (z2 + log_two_pi);
    score.native_sum2[facts.channel_of[i]] += evaluation.residual[i] * evaluation.residual[i];
    ++score.native_count[facts.channel_of[i]];
  }
  for (size_t group = 0; group < facts.groups.size(); ++group) {
    score.by_group[group] -= 0.5 * evaluation.log_det[group];
    score.log_likelihood += score.by_group[group];
  }
  for (size_t c = 0; c < facts.channels.size(); ++c) {
    score.native.push_back(
        score.native_count[c] ? std::sqrt(score.native_sum2[c] / score.native_count[c]) : 0);
  }
  return score;
}

Score Problem::score(const Model& model, const Groups& groups) const {
  return score_of(*this, evaluate(model, groups));
}

bool Problem::acts(const EffectDefinition& effect) const {
  return effects::acts_on(effect, facts_.set);
}

std::string Problem::not_testable(const Model&, const EffectDefinition& effect,
                                  size_t parameter) const {
  return effects::reason_against(effect, parameter, facts_.set);
}

std::vector<std::vector<double>> Problem::starts(const Model&,
                                                 const EffectDefinition& effect) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (rule.search == effects::StartSearch::listed) return rule.values;
  std::vector<std::vector<double>> all;
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> start;
    for (const effects::Parameter& parameter : effect.parameters) {
      const double value = parameter.neutral + sign * 0.05 * parameter.scale;
      const double inside = value < parameter.min || value > parameter.max
                                ? parameter.neutral - sign * 0.05 * parameter.scale
                                : value;
      start.push_back(parameter.integer ? parameter.neutral : inside);
    }
    all.push_back(std::move(start));
  }
  return all;
}

double Problem::looks(const Model& model, const EffectDefinition& effect) const {
  double looks = 1;
  for (const effects::Parameter& parameter : effect.parameters) {
    if (parameter.integer) looks *= static_cast<double>(starts(model, effect).size());
  }
  return looks;
}

std::string Problem::advice(const std::string& effect, const std::string& other) const {
  return effects::advice_between(effect, other, facts_.set.kind);
}

const std::vector<Groups>& Problem::folds() const {
  if (!folds_.empty()) return folds_;
  const size_t count = facts_.groups.size();
  if (count >= 4) {
    folds_ = {held_out_groups(facts_.groups)};
  } else {
    for (size_t out = 0; out < count; ++out) {
      Groups fold(count, 0);
      fold[out] = 1;
      folds_.push_back(std::move(fold));
    }
  }
  return folds_;
}

Groups Problem::training_groups() const {
  return facts_.groups.size() < 2 ? all_groups() : complement(folds().front());
}

}  // namespace seam::measurement
