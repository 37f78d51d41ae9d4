#include "measurement/problem/problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/problem/regimes.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

void Problem::check_columns(const Model& model, const std::vector<effects::Stage>& stages) const {
  const std::vector<std::string> known = formula_columns();
  for (const effects::ModelEffect& effect : model.effects()) {
    if (std::find(stages.begin(), stages.end(), effect.definition->stage) == stages.end()) continue;
    for (const std::string& column : effect.definition->columns) {
      if (std::find(known.begin(), known.end(), column) != known.end()) continue;
      throw InputError(fmt::format("{}: effect '{}' reads column '{}', which the set lacks{}",
                                   facts_.file, effect.definition->name, column,
                                   suggestion_for(column, known)));
    }
  }
}

double Score::error() const {
  const double freedom = static_cast<double>(n - nuisances);
  return freedom > 0 ? std::sqrt(chi2 / freedom) : std::numeric_limits<double>::quiet_NaN();
}

std::optional<size_t> index_of(const std::vector<Unknown>& unknowns, const Unknown& which) {
  const auto at = std::find(unknowns.begin(), unknowns.end(), which);
  if (at == unknowns.end()) return std::nullopt;
  return static_cast<size_t>(at - unknowns.begin());
}

std::vector<double> mean_parameters(const Model& model) {
  std::vector<double> key;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effect.definition->spread_only) continue;
    // Formulas of one name differ by their text.
    const std::string text = effect.definition->name + "\n" + effect.definition->source;
    key.push_back(static_cast<double>(std::hash<std::string>{}(text) >> 12));
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

namespace {

// What a scalar adds to minus twice the log-likelihood by its determinant. Where errors of a group
// are correlated, what that adds is spread over all of its scalars.
class LogDeterminants {
 public:
  LogDeterminants(const Facts& facts, const Evaluation& evaluation)
      : facts_(facts), evaluation_(evaluation), shared_(evaluation.log_det) {
    std::vector<double> count(shared_.size(), 0);
    for (size_t i = 0; i < facts.scalars(); ++i) {
      if (!evaluation.used[i]) continue;
      const int group = facts.group_of(i);
      ++count[group];
      shared_[group] -= 2 * std::log(evaluation.sigma[i]);
    }
    for (size_t g = 0; g < shared_.size(); ++g) shared_[g] /= std::max(1.0, count[g]);
  }
  double of(size_t scalar) const {
    return 2 * std::log(evaluation_.sigma[scalar]) + shared_[facts_.group_of(scalar)];
  }

 private:
  const Facts& facts_;
  const Evaluation& evaluation_;
  std::vector<double> shared_;
};

double log_two_pi() {
  return std::log(2 * maths::kPi);
}

// Adds a scalar to all that is summed over scalars but likelihoods.
void count(const Facts& facts, const Evaluation& evaluation, size_t i, Score& score) {
  const double z2 = evaluation.whitened[i] * evaluation.whitened[i];
  score.chi2 += evaluation.mean_square.empty() ? z2 : z2 / evaluation.mean_square[i];
  ++score.n;
  score.native_sum2[facts.channel_of[i]] += evaluation.residual[i] * evaluation.residual[i];
  ++score.native_count[facts.channel_of[i]];
}

Score empty_score(const Facts& facts, const Evaluation& evaluation) {
  Score score;
  score.valid = evaluation.valid;
  score.nuisances = evaluation.nuisances;
  score.native_sum2.assign(facts.channels.size(), 0);
  score.native_count.assign(facts.channels.size(), 0);
  return score;
}

void take_roots(Score& score) {
  score.valid = score.valid && std::isfinite(score.chi2);
  for (size_t c = 0; c < score.native_sum2.size(); ++c) {
    const double n = static_cast<double>(score.native_count[c]);
    score.native.push_back(n > 0 ? std::sqrt(score.native_sum2[c] / n) : 0);
  }
}

// By block: `only` one of them (-1: all).
void add_blocks(const Problem& problem, const Evaluation& evaluation, int only, Score& score) {
  const std::vector<int>& block = problem.blocks();
  if (block.empty()) return;
  const Facts& facts = problem.facts();
  const LogDeterminants determinants(facts, evaluation);
  score.by_block.assign(problem.block_count(), 0);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!evaluation.used[i] || (only >= 0 && block[i] != only)) continue;
    const double z2 = evaluation.whitened[i] * evaluation.whitened[i];
    score.by_block[block[i]] -= 0.5 * (z2 + log_two_pi() + determinants.of(i));
  }
}

std::vector<double> likelihoods_by_group(const Facts& facts, const Evaluation& evaluation) {
  std::vector<double> by_group(facts.groups.size(), 0);
  const double constant = log_two_pi();
  // A group's scalars mostly follow each other: its sum stays at hand until another's turn.
  size_t group = 0;
  double sum = 0;
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (!evaluation.used[i]) continue;
    if (const size_t own = facts.group_of(i); own != group)
      by_group[group] = sum, group = own, sum = by_group[own];
    const double z2 = evaluation.whitened[i] * evaluation.whitened[i];
    sum -= 0.5 * (z2 + constant);
  }
  if (!by_group.empty()) by_group[group] = sum;
  for (size_t group = 0; group < by_group.size(); ++group)
    by_group[group] -= 0.5 * evaluation.log_det[group];
  return by_group;
}

// With what is no single group's.
double together(const Facts& facts, const Evaluation& evaluation,
                const std::vector<double>& by_group) {
  double sum = 0;
  for (size_t i = facts.scalars(); i < evaluation.whitened.size(); ++i)
    sum -= 0.5 * evaluation.whitened[i] * evaluation.whitened[i];
  sum -= 0.5 * evaluation.shared_log_det;
  for (const double group : by_group) sum += group;
  return sum;
}

}  // namespace

double log_likelihood_of(const Problem& problem, const Evaluation& evaluation) {
  const Facts& facts = problem.facts();
  return together(facts, evaluation, likelihoods_by_group(facts, evaluation));
}

Score score_of(const Problem& problem, const Evaluation& evaluation) {
  const Facts& facts = problem.facts();
  Score score = empty_score(facts, evaluation);
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (evaluation.used[i]) count(facts, evaluation, i, score);
  }
  for (size_t i = facts.scalars(); i < evaluation.whitened.size(); ++i)
    score.chi2 += evaluation.whitened[i] * evaluation.whitened[i];
  score.by_group = likelihoods_by_group(facts, evaluation);
  score.log_likelihood = together(facts, evaluation, score.by_group);
  take_roots(score);
  add_blocks(problem, evaluation, -1, score);
  return score;
}

Score score_of_block(const Problem& problem, const Evaluation& evaluation, int block) {
  const Facts& facts = problem.facts();
  Score score = empty_score(facts, evaluation);
  const std::vector<int>& blocks = problem.blocks();
  for (size_t i = 0; i < facts.scalars(); ++i) {
    if (evaluation.used[i] && blocks[i] == block) count(facts, evaluation, i, score);
  }
  take_roots(score);
  add_blocks(problem, evaluation, block, score);
  score.log_likelihood = score.by_block[block];
  // One group alone is cut: what its blocks add is the group's.
  score.by_group.assign(facts.groups.size(), 0);
  return score;
}

Score Problem::score(const Model& model, const Groups& groups) const {
  return score_of(*this, evaluate(model, groups));
}

void Problem::say_left_out(const LeftOut& rows) {
  if (rows.empty()) return;
  facts_.left_out = rows.reasons;
  facts_.notes.insert(facts_.notes.begin(), rows.sentence());
}

void Problem::leave_out(std::vector<char> outliers) {
  // Marks that stand leave what was kept under them.
  if (outliers == left_out_) return;
  left_out_ = std::move(outliers);
  ++times_marked_;
  if (!beginnings_.problem) return;
  std::vector<char> first;
  for (const size_t i : beginnings_.scalar) first.push_back(!left_out_.empty() && left_out_[i]);
  beginnings_.problem->leave_out(std::move(first));
}

void Problem::resize_noise(const std::vector<double>& factor_of_channel) {
  for (size_t c = 0; c < facts_.channels.size(); ++c)
    facts_.channels[c].noise *= factor_of_channel[c];
  ++times_marked_;
  if (beginnings_.problem) beginnings_.problem->resize_noise(factor_of_channel);
}

bool Problem::acts(const EffectDefinition& effect) const {
  // A user's formula that names a column that is not there is an error, which its kind states.
  const bool is_formula = !effect.source.empty();
  const auto has = [&](const std::string& column) {
    return std::any_of(facts_.covariates.begin(), facts_.covariates.end(),
                       [&](const Covariate& covariate) { return covariate.name == column; });
  };
  return (is_formula || std::all_of(effect.columns.begin(), effect.columns.end(), has)) &&
         effects::acts_on(effect, facts_.set);
}

std::string Problem::not_testable(const Model&, const EffectDefinition& effect,
                                  size_t parameter) const {
  // A user's formula may mean a number that stays.
  const std::vector<std::string> reads =
      effect.source.empty() ? effect.columns : std::vector<std::string>();
  for (const Covariate& covariate : facts_.covariates) {
    if (std::find(reads.begin(), reads.end(), covariate.name) == reads.end()) continue;
    const auto [least, most] =
        std::minmax_element(covariate.values.begin(), covariate.values.end());
    if (least != covariate.values.end() && *least == *most)
      return fmt::format("the column {} is {:g} in every row", covariate.name, *least);
  }
  return effects::reason_against(effect, parameter, facts_.set);
}

std::vector<std::vector<double>> Problem::starts(const Model& model,
                                                 const EffectDefinition& effect) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (rule.search == effects::StartSearch::listed) return rule.values;
  if (rule.search == effects::StartSearch::best_listed)
    return {likeliest(model, effect, rule, folds().size() == 1 ? training_groups() : all_groups())};
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

std::vector<std::vector<double>> Problem::starts_together(const Model& model,
                                                          const EffectDefinition& effect,
                                                          const EffectList&) const {
  return starts(model, effect);
}

std::vector<std::vector<double>> Problem::starts_on(const Groups& groups, const Model& model,
                                                    const EffectDefinition& effect,
                                                    const EffectList& companions) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (rule.search == effects::StartSearch::best_listed)
    return {likeliest(model, effect, rule, groups)};
  return starts_together(model, effect, companions);
}

std::vector<double> Problem::likeliest(const Model& model, const EffectDefinition& effect,
                                       const effects::StartRule& rule, const Groups& groups) const {
  Model trial = model;
  trial.add_neutral(std::make_shared<EffectDefinition>(effect));
  const Evaluation here = evaluate(model, groups);
  double best = -std::numeric_limits<double>::infinity();
  const std::vector<double>* values = &rule.values.front();
  for (const std::vector<double>& start : rule.values) {
    for (size_t i = 0; i < start.size(); ++i) trial.set_value(effect.name, i, start[i]);
    const Evaluation there = evaluate(trial, groups, &here);
    const double likelihood = there.valid ? log_likelihood_of(*this, there) : best;
    if (likelihood > best) best = likelihood, values = &start;
  }
  return *values;
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
  std::call_once(folds_cut_, [&] {
    const size_t count = facts_.groups.size();
    if (count >= groups_for_one_fold()) {
      folds_ = {held_out_of_each(facts_.groups, regimes())};
      return;
    }
    for (size_t out = 0; out < count; ++out) {
      Groups fold(count, 0);
      fold[out] = 1;
      folds_.push_back(std::move(fold));
    }
  });
  return folds_;
}

std::vector<Groups> Problem::regimes() const {
  return regimes_of_labels(facts_);
}

Groups Problem::scored_groups() const {
  return folds().size() == 1 ? folds().front() : all_groups();
}

const std::vector<int>& Problem::blocks() const {
  std::call_once(blocks_cut_, [&] { cut_blocks(); });
  return blocks_;
}

// As many observations in each block of a group, in the order of time.
void Problem::cut_blocks() const {
  constexpr size_t kBlocks = 8;         // In all groups together, or a few more.
  constexpr size_t kLeastOfABlock = 8;  // Observations.
  const size_t groups = facts_.groups.size();
  if (groups == 0 || groups >= kFewGroups) return;
  std::vector<std::vector<size_t>> of_group(groups);
  for (size_t i = 0; i < facts_.scalars(); ++i) of_group[facts_.group_of(i)].push_back(i);
  blocks_.assign(facts_.scalars(), 0);
  for (std::vector<size_t>& scalars : of_group) {
    std::stable_sort(scalars.begin(), scalars.end(), [&](size_t a, size_t b) {
      return facts_.time_of_row[facts_.row_of[a]] < facts_.time_of_row[facts_.row_of[b]];
    });
    const size_t wished = std::max<size_t>(2, (kBlocks + groups - 1) / groups);
    const size_t parts = std::clamp<size_t>(scalars.size() / kLeastOfABlock, 1, wished);
    for (size_t k = 0; k < scalars.size(); ++k)
      blocks_[scalars[k]] = static_cast<int>(block_count_ + k * parts / scalars.size());
    block_count_ += parts;
  }
}

Groups Problem::training_groups() const {
  return facts_.groups.size() < 2 ? all_groups() : complement(folds().front());
}

}  // namespace seam::measurement
