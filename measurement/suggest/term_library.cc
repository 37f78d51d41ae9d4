#include "measurement/suggest/term_library.h"

#include <algorithm>
#include <cmath>

#include "measurement/judge/judge.h"
#include "measurement/numerics/parallel_for.h"
#include "measurement/suggest/bump_search.h"
#include "measurement/suggest/wave_search.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Decays are looked at from the variable's range down, each half as long, and steps and bends at
// evenly many observations; a number is then moved within its neighbours. Judgements.
constexpr int kDecays = 4;
constexpr int kPlaces = 8;
constexpr int kHalvings = 6;
constexpr int kMostStepTrials = 6;
constexpr double kLargestStep = 10;
// Terms whose numbers are moved, and of which fits are tried before a formula is at its end, and
// from which correlation on a term is one that was tried, unless it has fewer numbers. Judgements.
constexpr size_t kMostMoved = 12, kMostTried = 3;
constexpr double kAlike = 0.9;

Term carrying(Term term, const std::string& what) {
  for (Term::Piece& piece : term.pieces) {
    const size_t at = piece.text.find('@');
    piece.text = piece.text.replace(at, 1, what);
  }
  return term;
}

Term curve_on(Term carrier, Curve curve, const std::string& variable, double span) {
  carrier.curve = curve, carrier.variable = variable, carrier.span = span;
  return carrier;
}

// Coefficients and numbers of terms, as their effect's parameters.
std::vector<effects::ParameterValue> parameters_of(const std::vector<Term>& terms) {
  std::vector<effects::ParameterValue> values;
  for (const Term& term : terms) {
    values.push_back({.value = std::abs(term.coefficient)});
    if (!is_fitted(term.curve)) continue;
    for (const double number : term.numbers) values.push_back({.value = number});
  }
  return values;
}

// But for what differences round off.
bool is_constant(const std::vector<double>& values) {
  constexpr double kRounding = 1e-5;
  if (values.empty()) return true;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return !(*high - *low > kRounding * std::max(std::abs(*low), std::abs(*high)));
}

}  // namespace

Model with_formula(Model model, const std::shared_ptr<const EffectDefinition>& effect,
                   const std::vector<Term>& terms) {
  model.set(effect, parameters_of(terms));
  return model;
}

TermLibrary::TermLibrary(const Problem& problem, const Model& base, const Vocabulary& vocabulary)
    : base_(base), vocabulary_(vocabulary) {
  // One group alone is held out by blocks, none of them here.
  const Groups training = problem.training_groups();
  rows_ = few_of(problem, base, training).value_or(FewRows{&problem, training});
  count_ = static_cast<double>(std::max<size_t>(3, count_used(problem)));
  start_ = rows_.problem->evaluate(base, rows_.groups);
  if (!valid()) return;
  changes_ = rows_.problem->small_changes(base, rows_.groups, start_);
  share_ = count_ / std::max(3.0, residuals_of(rows_));
  add_terms();
}

void TermLibrary::add_terms() {
  terms_ = vocabulary_.terms;
  // Most curves are of size 1: what a carrier's step is by itself is theirs.
  std::vector<double> steps(terms_.size(), 1e-6);
  const Facts& facts = rows_.problem->facts();
  std::vector<FieldPlace> places;
  if (!vocabulary_.place.outputs.empty()) places = places_of();
  for (const Term& carrier : vocabulary_.carriers) {
    double step = 1e-6;
    const ByScalar alone = derivative(carrying(carrier, "1"), &step);
    for (const std::string& variable : vocabulary_.variables) {
      auto along = along_channel(vocabulary_, *rows_.problem, start_, carrier, variable);
      if (!along) along = along_place(vocabulary_, places, facts, start_, carrier, variable);
      if (!along) along = along_changes(start_, alone, derivative(carrying(carrier, variable)));
      if (is_constant(along->at)) continue;
      std::vector<double> values = values_of(vocabulary_, facts, variable);
      add_curves(carrier, variable, values.empty() ? along->at : std::move(values));
      along->carrier = carrier, along->variable = variable;
      along_.push_back(*std::move(along));
    }
    steps.resize(terms_.size(), step);
  }
  library_.resize(terms_.size());
  parallel_for(library_.size(), [&](size_t i) { library_[i] = derivative(terms_[i], &steps[i]); });
}

// Of all groups, as a problem asks.
std::vector<FieldPlace> TermLibrary::places_of() const {
  const Problem& problem = *rows_.problem;
  const Evaluation here = problem.evaluate(base_, problem.all_groups());
  return here.valid ? problem.field_places(base_, here) : std::vector<FieldPlace>();
}

double TermLibrary::looks() const {
  const size_t waves = vocabulary_.carriers.size() * vocabulary_.variables.size();
  return static_cast<double>(terms_.size()) + kMostWaves * static_cast<double>(waves);
}

double TermLibrary::dot(const ByScalar& a, const ByScalar& b) const {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += start_.used[i] ? a[i] * b[i] : 0;
  return sum;
}

void TermLibrary::take_out(const ByScalar& direction, ByScalar& from) const {
  const double along = dot(direction, from);
  for (size_t i = 0; i < from.size(); ++i) from[i] -= along * direction[i];
}

// Of the whitened residuals by the term's coefficient; empty where the term changes nothing.
TermLibrary::ByScalar TermLibrary::derivative(const Term& term, double* step_to_try) const {
  std::vector<Term> probes = {term};
  probes[0].coefficient = 1;
  const auto effect =
      formula_effect(formula_yaml("probe", vocabulary_.stage, "A probe.", probes), "probe");
  // A step of about the noise: the path of a body errs by a small part of that, and hardly any
  // prediction bends over it.
  double step = step_to_try != nullptr ? *step_to_try : 1e-6;
  ByScalar column;
  for (int attempt = 0; attempt < kMostStepTrials; ++attempt) {
    probes[0].coefficient = step;
    column = changes_->to(with_formula(base_, effect, probes));
    double sum2 = 0;
    for (size_t i = 0; i < column.size(); ++i) {
      column[i] = start_.used[i] ? column[i] / step : 0;
      if (!std::isfinite(column[i])) return {};
      sum2 += column[i] * column[i];
    }
    const double moved = std::sqrt(sum2 * share_ / count_) * step;
    if (!(moved > 0)) return {};
    if ((moved > 0.1 && moved < 3) || (step == kLargestStep && moved < 3)) break;
    step = std::min(step / moved, kLargestStep);
  }
  if (step_to_try != nullptr) *step_to_try = step;
  return column;
}

// Residuals and what the fitted parameters span, under this model.
void TermLibrary::look_from(const Assessment& here) {
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
TermLibrary::ByScalar TermLibrary::beyond(ByScalar column) const {
  if (column.empty()) return {};
  const double before = dot(column, column);
  for (int twice = 0; twice < 2; ++twice) {
    for (const ByScalar& direction : basis_) take_out(direction, column);
  }
  const double after = dot(column, column);
  if (!(after > kSpanned * before) || !(after > 0)) return {};
  for (double& value : column) value /= std::sqrt(after);
  return column;
}

// What a term gains by its column, less its price; nothing where the fitted parameters span it.
TermLibrary::Worth TermLibrary::worth_of(Term term, const ByScalar& column) const {
  ByScalar own = beyond(column);
  if (own.empty()) return {};
  const double gain = 0.5 * share_ * std::pow(dot(own, rest_), 2);
  set_coefficient(column, own, term);
  return {gain - term.parameters() * price_of_number(), std::move(term), std::move(own)};
}

std::vector<TermLibrary::Worth> TermLibrary::worths() const {
  const double price = price_of_number();
  std::vector<Worth> worths(terms_.size());
  parallel_for(terms_.size(), [&](size_t i) { worths[i] = worth_of(terms_[i], library_[i]); });
  for (const Along& along : along_) {
    double gain = 0;
    auto wave = best_wave(along, gain);
    if (wave && gain > wave->parameters() * price) {
      const ByScalar column = derivative(*wave);
      ByScalar own = beyond(column);
      if (along.arrives && !own.empty()) set_coefficient(column, own, *wave);
      if (!own.empty())
        worths.push_back({gain - wave->parameters() * price, *std::move(wave), std::move(own)});
    }
    if (const auto bump = best_bump(along)) worths.push_back(worth_of(*bump, derivative(*bump)));
  }
  sort(worths);
  return worths;
}

std::vector<Term> TermLibrary::best_terms(const Assessment& here) {
  look_from(here);
  std::vector<Worth> best = unlike(worths(), kMostMoved);
  // A curve whose place is among a few is often behind until it stands where it belongs.
  parallel_for(best.size(), [&](size_t i) {
    if (best[i].term.numbers.empty() || best[i].term.curve == Curve::wave) return;
    const Term moved = moved_to_the_best(best[i].term);
    best[i] = worth_of(moved, derivative(moved));
  });
  sort(best);
  std::vector<Term> terms;
  for (const Worth& worth : unlike(std::move(best), kMostTried)) terms.push_back(worth.term);
  return terms;
}

void TermLibrary::sort(std::vector<Worth>& worths) {
  std::stable_sort(worths.begin(), worths.end(),
                   [](const Worth& a, const Worth& b) { return a.worth > b.worth; });
}

// The first of those that gain more than they cost, each unlike those before it.
std::vector<TermLibrary::Worth> TermLibrary::unlike(std::vector<Worth> worths, size_t most) const {
  std::vector<Worth> best;
  for (Worth& worth : worths) {
    if (!(worth.worth > 0) || best.size() == most) break;
    if (std::none_of(best.begin(), best.end(), [&](const Worth& before) {
          return before.term.parameters() <= worth.term.parameters() &&
                 std::abs(dot(before.own, worth.own)) > kAlike;
        }))
      best.push_back(std::move(worth));
  }
  return best;
}

// A fit starts where the fitted parameters are at rest, on a small part of the way that the
// coefficient goes without them: they have to follow. `size`: how far it goes when they do.
void TermLibrary::set_coefficient(const ByScalar& column, const ByScalar& own, Term& term) const {
  constexpr double kPart = 0.1;
  term.coefficient = -kPart * dot(column, rest_) / dot(column, column);
  term.size = std::abs(dot(own, rest_) / dot(own, column));
}

double TermLibrary::price_of_number() const {
  return kPriceOfNumber * std::log(count_) * misfit_;
}

std::vector<double> TermLibrary::rest_of(const Along& along) const {
  std::vector<double> rest;
  for (const size_t i : along.scalars) rest.push_back(rest_[i]);
  return rest;
}

// The strongest wave in a variable where the carrier acts.
std::optional<Term> TermLibrary::best_wave(const Along& along, double& gain) const {
  const auto wave = strongest_wave(along.at, along.weight, rest_of(along), along.arrives);
  if (!wave) return std::nullopt;
  gain = share_ * wave->gain;
  Term term = curve_on(along.carrier, Curve::wave, along.variable, 0);
  term.numbers = {wave->frequency, wave->phase};
  term.coefficient = wave->amplitude;
  return term;
}

std::optional<Term> TermLibrary::best_bump(const Along& along) const {
  const auto bump = strongest_bump(along.at, along.weight, rest_of(along), along.arrives);
  if (!bump) return std::nullopt;
  const auto [low, high] = std::minmax_element(along.at.begin(), along.at.end());
  Term term = curve_on(along.carrier, Curve::bump, along.variable, *high - *low);
  term.numbers = {bump->place, bump->width};
  return term;
}

// Curves at places of a variable that has these values.
void TermLibrary::add_curves(const Term& carrier, const std::string& variable,
                             std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  std::sort(values.begin(), values.end());
  if (values.size() < kLeastForWaves) return;
  const double span = values.back() - values.front();
  const auto add = [&](Curve curve, std::vector<double> numbers) {
    Term term = curve_on(carrier, curve, variable, span);
    term.numbers = std::move(numbers);
    terms_.push_back(std::move(term));
  };
  // A decay begins where the variable does, or nearly.
  if (values.front() > -0.1 * span && values.front() < span) {
    for (int k = 0; k < kDecays; ++k) {
      for (const Curve curve : {Curve::decay, Curve::rise}) add(curve, {std::ldexp(span, -k)});
    }
  }
  for (int k = 1; k < kPlaces; ++k) {
    const double place = values[values.size() * k / kPlaces];
    for (const Curve curve : {Curve::from, Curve::until, Curve::above, Curve::below})
      add(curve, {place});
    // What stays the same is often fitted already where the curve acts on something else.
    if (carrier.pieces.size() == 1 && carrier.pieces[0].text == "@") add(Curve::line, {place});
  }
}

// The term with its curve's numbers moved to where it takes the most.
Term TermLibrary::moved_to_the_best(Term term) const {
  const auto gain_of = [&](const Term& other) {
    const ByScalar own = beyond(derivative(other));
    return own.empty() ? 0 : std::pow(dot(own, rest_), 2);
  };
  double most = gain_of(term), part = 1;
  for (int halved = 0; halved < kHalvings; ++halved) {
    part *= 0.5;
    for (size_t k = 0; k < term.numbers.size(); ++k) {
      for (const double by : {-part, part}) {
        Term other = term;
        if (is_size(term.curve, k))
          other.numbers[k] *= std::exp2(by);
        else
          other.numbers[k] += by * term.span / kPlaces;
        if (const double gain = gain_of(other); gain > most) most = gain, term = std::move(other);
      }
    }
  }
  return term;
}

}  // namespace seam::measurement
