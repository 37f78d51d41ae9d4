#include "measurement/suggest/proposer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "measurement/fitting/few_groups.h"
#include "measurement/judge/judge.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/numerics/regression.h"
#include "sim_core/base/maths.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

using ByScalar = std::vector<double>;

class Proposer {
 public:
  Proposer(const Problem& problem, const Assessment& base, const Vocabulary& vocabulary)
      : problem_(problem), base_(base), vocabulary_(vocabulary) {
    // One group alone is held out by blocks, none of them here.
    const Groups training = problem.training_groups();
    rows_ = few_of(problem, base.model, training).value_or(FewRows{&problem, training});
    count_ = static_cast<double>(std::max<size_t>(3, count_used(problem)));
  }

  std::optional<Formula> run();

 private:
  // An inner product over the rows looked at, so that coefficients know nothing of held-out ones.
  double dot(const ByScalar& a, const ByScalar& b) const {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += start_.used[i] ? a[i] * b[i] : 0;
    return sum;
  }
  void take_out(const ByScalar& direction, ByScalar& from) const {
    const double along = dot(direction, from);
    for (size_t i = 0; i < from.size(); ++i) from[i] -= along * direction[i];
  }

  // Terms that are looked at for one.
  double looks() const {
    const size_t waves = vocabulary_.outputs.size() * vocabulary_.variables.size();
    return static_cast<double>(vocabulary_.terms.size()) + kMostWaves * static_cast<double>(waves);
  }

  std::string name() const;
  Model with(const std::shared_ptr<const EffectDefinition>& effect, double value) const;
  ByScalar derivative(const Term& term) const;
  void look_from(const Assessment& here);
  ByScalar beyond(ByScalar column) const;
  std::optional<Term> best_term() const;
  std::optional<Term> best_wave(const std::string& output, const std::string& variable,
                                double& gain) const;
  Formula fitted(std::vector<Term> terms) const;
  bool supported(const Formula& before, const Formula& after) const;
  Formula without_needless(Formula found) const;

  const Problem& problem_;
  const Assessment& base_;
  const Vocabulary& vocabulary_;
  FewRows rows_;                           // Of training groups: where terms are looked for.
  double count_ = 0;                       // Of all residuals,
  double share_ = 1;                       // and how many there are for each that is looked at.
  Evaluation start_;                       // Of the model without the formula.
  std::vector<ByScalar> library_;          // Derivatives by each term's coefficient;
  std::map<std::string, ByScalar> alone_;  // by a constant in an output,
  std::map<std::pair<std::string, std::string>, ByScalar> times_;  // and by a variable in it.
  std::vector<ByScalar> basis_;  // What the fitted parameters span, orthonormal.
  ByScalar rest_;                // What they leave.
  double misfit_ = 1;
};

std::string Proposer::name() const {
  std::string name = "suggested";
  for (int i = 2; base_.model.has(name); ++i) name = "suggested_" + std::to_string(i);
  return name;
}

Model Proposer::with(const std::shared_ptr<const EffectDefinition>& effect, double value) const {
  Model model = base_.model;
  model.set(effect, {{.value = value}});
  return model;
}

// Of the whitened residuals by the term's coefficient; empty where the term changes nothing.
ByScalar Proposer::derivative(const Term& term) const {
  std::vector<Term> probes = {term};
  probes[0].coefficient = 1;
  const auto effect =
      formula_effect(formula_yaml("probe", vocabulary_.stage, "A probe.", probes), "probe");
  // The second step is of a size that changes residuals by a thousandth of the noise.
  double step = 1e-6;
  ByScalar column;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const Evaluation there = rows_.problem->evaluate(with(effect, step), rows_.groups, &start_);
    if (!there.valid) return {};
    column.assign(there.whitened.size(), 0);
    double sum2 = 0;
    for (size_t i = 0; i < column.size(); ++i) {
      if (!start_.used[i]) continue;
      column[i] = (there.whitened[i] - start_.whitened[i]) / step;
      if (!std::isfinite(column[i])) return {};
      sum2 += column[i] * column[i];
    }
    const double rms = std::sqrt(sum2 * share_ / count_);
    if (!(rms > 0)) return {};
    step = std::min(3e-3 / rms, 10.0);
  }
  return column;
}

// Residuals and what the fitted parameters span, under this model.
void Proposer::look_from(const Assessment& here) {
  const Evaluation evaluation = rows_.problem->evaluate(here.model, rows_.groups);
  std::vector<Unknown> unknowns;
  for (const Unknown& unknown : here.unknowns) {
    if (!here.model.find(unknown.effect)->definition->spread_only) unknowns.push_back(unknown);
  }
  basis_.clear();
  if (!unknowns.empty()) {
    for (ByScalar& column :
         rows_.problem->jacobian(here.model, unknowns, rows_.groups, evaluation)) {
      column = beyond(std::move(column));
      if (!column.empty()) basis_.push_back(std::move(column));
    }
  }
  rest_ = evaluation.whitened;
  for (const ByScalar& direction : basis_) take_out(direction, rest_);
  misfit_ = std::max(1.0, here.error * here.error);
}

// The part of a column that the fitted parameters do not span, of unit length; empty: none.
ByScalar Proposer::beyond(ByScalar column) const {
  const double before = dot(column, column);
  for (int twice = 0; twice < 2; ++twice) {
    for (const ByScalar& direction : basis_) take_out(direction, column);
  }
  const double after = dot(column, column);
  if (!(after > kSpanned * before) || !(after > 0)) return {};
  for (double& value : column) value /= std::sqrt(after);
  return column;
}

std::optional<Term> Proposer::best_term() const {
  std::vector<double> gains(library_.size(), 0);
  parallel_for(library_.size(), [&](size_t i) {
    if (library_[i].empty()) return;
    const ByScalar column = beyond(library_[i]);
    if (!column.empty()) gains[i] = 0.5 * share_ * std::pow(dot(column, rest_), 2);
  });
  const double price = kPriceOfClear * std::log(count_) * misfit_;
  std::optional<Term> best;
  double most = 0;
  for (size_t i = 0; i < library_.size(); ++i) {
    const double worth = gains[i] - price;
    if (!(worth > most)) continue;
    most = worth, best = vocabulary_.terms[i];
    best->coefficient = -dot(library_[i], rest_) / dot(library_[i], library_[i]);
  }
  for (const std::string& output : vocabulary_.outputs) {
    for (const std::string& variable : vocabulary_.variables) {
      double gain = 0;
      auto wave = best_wave(output, variable, gain);
      if (wave && gain - kWaveParameters * price > most)
        most = gain - kWaveParameters * price, best = std::move(wave);
    }
  }
  return best;
}

// The strongest wave in a variable. The variable's value at each residual is what it would change
// beside what a constant would; that is exact where the output stands for the residual itself, and
// near enough elsewhere to find the frequency.
std::optional<Term> Proposer::best_wave(const std::string& output, const std::string& variable,
                                        double& gain) const {
  const ByScalar& one = alone_.at(output);
  const ByScalar& by_variable = times_.at({output, variable});
  if (one.empty() || by_variable.empty()) return std::nullopt;
  double largest = 0;
  for (const double value : one) largest = std::max(largest, std::abs(value));
  std::vector<double> at, weight, rest;
  for (size_t i = 0; i < one.size(); ++i) {
    if (!start_.used[i] || std::abs(one[i]) < kLeastActing * largest) continue;
    at.push_back(by_variable[i] / one[i]), weight.push_back(one[i]), rest.push_back(rest_[i]);
  }
  if (at.size() < kLeastForWaves) return std::nullopt;
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  const double span = *high - *low;
  if (!(span > 0)) return std::nullopt;
  struct Sums {
    double ss = 0, cc = 0, sc = 0, sr = 0, cr = 0;
    double determinant() const { return ss * cc - sc * sc; }
    double gain() const {
      const double d = determinant();
      return d > 1e-9 * ss * cc ? 0.5 * (cc * sr * sr - 2 * sc * sr * cr + ss * cr * cr) / d : 0;
    }
  };
  const auto look = [&](double frequency) {
    Sums sums;
    for (size_t i = 0; i < at.size(); ++i) {
      const double s = weight[i] * std::sin(frequency * at[i]);
      const double c = weight[i] * std::cos(frequency * at[i]);
      sums.ss += s * s, sums.cc += c * c, sums.sc += s * c, sums.sr += s * rest[i];
      sums.cr += c * rest[i];
    }
    return sums;
  };
  const double step = maths::kPi / span;
  std::vector<double> gains(kMostWaves + 1, 0);
  parallel_for(kMostWaves - 1, [&](size_t k) { gains[k + 2] = look((k + 2.0) * step).gain(); });
  // Rows at even steps show two frequencies alike: of equals the slower one.
  const double most = *std::max_element(gains.begin(), gains.end());
  double frequency = 0, best = 0;
  for (size_t k = 2; k < gains.size(); ++k) {
    const bool peak =
        gains[k] >= gains[k - 1] && (k + 1 == gains.size() || gains[k] > gains[k + 1]);
    if (!peak || gains[k] < kNearlyAsStrong * most) continue;
    double f = static_cast<double>(k) * step;
    for (double width = 0.5 * step; width > 1e-4 * step; width *= 0.6) {
      for (const double other : {f - width, f + width}) {
        if (other > step && look(other).gain() > look(f).gain()) f = other;
      }
    }
    const double here = look(f).gain();
    if (here > kClearlyStronger * best) frequency = f, best = here;
  }
  const Sums sums = look(frequency);
  gain = share_ * sums.gain();
  if (!(gain > 0)) return std::nullopt;
  const double d = sums.determinant();
  const double by_sine = -(sums.cc * sums.sr - sums.sc * sums.cr) / d;
  const double by_cosine = -(sums.ss * sums.cr - sums.sc * sums.sr) / d;
  return Term{.pieces = {{output, "sin(@)"}},
              .variable = variable,
              .frequency = frequency,
              .phase = std::atan2(by_cosine, by_sine),
              .coefficient = std::hypot(by_sine, by_cosine)};
}

// The model with these terms, every coefficient fitted.
Formula Proposer::fitted(std::vector<Term> terms) const {
  Formula found{.vocabulary = &vocabulary_, .terms = std::move(terms)};
  if (found.terms.empty()) {
    found.assessment = base_;
    return found;
  }
  const std::string effect_name = name();
  const std::string yaml = formula_yaml(effect_name, vocabulary_.stage, "A trial.", found.terms);
  const auto effect = formula_effect(yaml, effect_name);
  std::vector<effects::ParameterValue> values;
  for (const Term& term : found.terms) {
    values.push_back({.value = std::abs(term.coefficient)});
    if (term.is_wave())
      values.push_back({.value = term.frequency}), values.push_back({.value = term.phase});
  }
  Model model = base_.model;
  model.set(effect, values);
  std::vector<Unknown> unknowns = base_.unknowns;
  for (size_t i = 0; i < values.size(); ++i) unknowns.push_back({effect_name, i});
  found.assessment = assess(problem_, model, unknowns);
  const auto fit = found.assessment.model.find(effect_name)->values();
  size_t at = 0;
  for (Term& term : found.terms) {
    term.coefficient = std::copysign(1.0, term.coefficient) * fit[at++];
    if (!term.is_wave()) continue;
    term.frequency = fit[at++], term.phase = fit[at++];
  }
  const double misfit = std::max(1.0, found.assessment.error * found.assessment.error);
  found.merit = found.log_evidence = found.assessment.total_ll;
  for (const Term& term : found.terms) {
    const double price = kPriceOfClear * std::log(count_) * term.parameters();
    found.merit -= price * misfit;
    found.log_evidence -= price + std::log(looks());
  }
  return found;
}

bool Proposer::supported(const Formula& before, const Formula& after) const {
  if (!after.assessment.valid) return false;
  const Term& last = after.terms.back();
  const double misfit = std::max(1.0, after.assessment.error * after.assessment.error);
  const double ratio = 2 * (after.assessment.total_ll - before.assessment.total_ll) / misfit;
  if (!(chi2_tail(ratio, last.parameters()) * looks() < kCandidateAlarm)) return false;
  const double excess = std::pow(before.assessment.error, 2) - 1;
  const double left = std::pow(after.assessment.error, 2) - 1;
  if (before.assessment.error > kMisfit && left > (1 - kLeastOfExcess) * excess) return false;
  // Most held-out groups must gain, or their blocks where groups are few; and residuals fall in
  // their own units by what is worth reading about: an error in units of a noise that is fitted
  // beside the formula says nothing.
  const Score& held = after.assessment.held;
  const double z = gain_over_scatter(before.assessment.held, held, kGroupsForAgreement);
  if (after.assessment.held_ll() <= before.assessment.held_ll() || z < kAgreedFormula) return false;
  double most = 0;
  for (size_t c = 0; c < held.native.size(); ++c) {
    if (held.native[c] > 0)
      most = std::max(most, 1 - std::pow(held.native[c] / before.assessment.held.native[c], 2));
  }
  return most > kLeastWorthReading;
}

// Terms that later ones have made unnecessary go.
Formula Proposer::without_needless(Formula found) const {
  for (size_t i = 0; i < found.terms.size() && found.terms.size() > 1;) {
    std::vector<Term> fewer = found.terms;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
    Formula smaller = fitted(std::move(fewer));
    if (smaller.assessment.valid && smaller.merit >= found.merit) {
      found = std::move(smaller), i = 0;
    } else {
      ++i;
    }
  }
  return found;
}

std::optional<Formula> Proposer::run() {
  start_ = rows_.problem->evaluate(base_.model, rows_.groups);
  if (!start_.valid || start_.whitened.empty()) return std::nullopt;
  share_ = count_ / std::max(3.0, residuals_of(rows_));
  library_.resize(vocabulary_.terms.size());
  const Work work("parts of the formula", kMostTerms + 1, Work::Of::at_most);
  parallel_for(library_.size(), [&](size_t i) { library_[i] = derivative(vocabulary_.terms[i]); });
  for (const std::string& output : vocabulary_.outputs) {
    alone_[output] = derivative({.pieces = {{output, "1"}}});
    for (const std::string& variable : vocabulary_.variables)
      times_[{output, variable}] = derivative({.pieces = {{output, variable}}});
  }
  Formula found = fitted({});
  while (found.terms.size() < kMostTerms) {
    work.done();
    look_from(found.assessment);
    const std::optional<Term> term = best_term();
    if (!term) break;
    std::vector<Term> more = found.terms;
    more.push_back(*term);
    Formula next = fitted(std::move(more));
    if (!supported(found, next)) break;
    found = std::move(next);
  }
  return found.terms.empty() ? std::nullopt : std::optional(without_needless(std::move(found)));
}

}  // namespace

std::optional<Formula> formula_of(const Problem& problem, const Assessment& base,
                                  const Vocabulary& vocabulary) {
  return Proposer(problem, base, vocabulary).run();
}

}  // namespace seam::measurement
