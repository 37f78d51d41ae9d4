// Fits of servo models.
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>

#include "effects/questions.h"
#include "measurement/fitting/assess.h"
#include "measurement/fitting/few_groups.h"
#include "measurement/fitting/wide_fit.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/numerics/span.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

namespace {

// Of values that give the same effect, those that its record wants told.
void tell_once(Fit& fit, const std::vector<Unknown>& unknowns) {
  const Model found = fit.model;
  for (const effects::ModelEffect& effect : found.effects()) {
    const EffectDefinition& definition = *effect.definition;
    if (!definition.told_once) continue;
    std::vector<size_t> places;
    for (size_t i = 0; i < unknowns.size(); ++i) {
      if (unknowns[i].effect == definition.name) places.push_back(i);
    }
    if (places.size() < definition.parameters.size()) continue;
    std::vector<double> values(definition.parameters.size());
    for (const size_t i : places) values[unknowns[i].parameter] = fit.value[i];
    definition.told_once(values);
    for (const size_t i : places) {
      fit.value[i] = values[unknowns[i].parameter];
      fit.model.set_value(definition.name, unknowns[i].parameter, fit.value[i]);
    }
  }
}

}  // namespace

Fit JointsProblem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                       const Groups& groups) const {
  const bool motor = effects::has_base(start, effects::Base::motor);
  Fit fit = motor ? fit_motor(start, unknowns, groups) : wide_fit(*this, start, unknowns, groups);
  if (motor) state_errors(fit, unknowns, groups);
  tell_once(fit, unknowns);
  return fit;
}

std::vector<std::vector<double>> JointsProblem::jacobian(const Model& model,
                                                         const std::vector<Unknown>& unknowns,
                                                         const Groups& groups,
                                                         const Evaluation& here) const {
  if (effects::has_base(model, effects::Base::motor))
    return motor_jacobian(model, unknowns, groups, here);
  return wide_jacobian(*this, model, unknowns, groups);
}

namespace {

constexpr double kCoarse = 1.2;  // From one value of the coarse look to the next.

// The values of the coarse look. An eccentricity (`wave`) has a phase besides, and the likelihood
// is wide in its amplitude; a motor's motion is smooth in its parameters, its valleys are wide too.
std::vector<std::vector<double>> coarse_grid(const EffectDefinition& effect, bool wave,
                                             bool motor) {
  const effects::Parameter& first = effect.parameters[0];
  std::vector<double> neutral;
  for (const effects::Parameter& p : effect.parameters) neutral.push_back(p.neutral);
  std::vector<std::vector<double>> grid;
  for (double factor = 0.03; factor < 40; factor *= wave || motor ? 3 : kCoarse) {
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> values = neutral;
      if (effect.logged && !wave) {
        // One parameter a joint: small in all, either sign; encoders are smooth.
        for (double& value : values) value = sign * 0.1 * first.scale;
        if (factor < 0.04) grid.push_back(values);
        continue;
      }
      values[0] = sign * factor * first.scale;
      if (values[0] < first.min || values[0] > first.max) continue;
      grid.push_back(values);
      if (!wave) continue;
      for (const double phase : {1.5, 3.0, -1.5}) {
        values[1] = phase;
        grid.push_back(values);
      }
    }
  }
  return grid;
}

}  // namespace

namespace {

// From 33 to 0.9 Hz. A swing that is damped by a tenth of the critical damping is as wide as a
// fifth of its frequency: from one look to the next it is half seen.
constexpr double kShortest_s = 0.03, kLongest_s = 1.1, kNext = 1.25;
constexpr double kDampings[] = {0.05, 0.25};

std::vector<double> periods_s() {
  std::vector<double> periods;
  for (double period_s = kShortest_s; period_s < kLongest_s; period_s *= kNext)
    periods.push_back(period_s);
  return periods;
}

// What the model's own values can do about residuals.
Span span_of_values(const JointsProblem& problem, const Model& model, const Groups& groups,
                    const Evaluation& here) {
  std::vector<Unknown> unknowns = refitted_unknowns(model);
  std::erase_if(unknowns, [&](const Unknown& unknown) {
    return model.find(unknown.effect)->definition->spread_only;
  });
  Span span;
  if (unknowns.empty()) return span;
  for (std::vector<double>& column : problem.jacobian(model, unknowns, groups, here)) {
    constexpr double kOwn = 1e-6;  // Of its length: less is rounding.
    const double whole = span.take_out_of(column);
    if (length(column) > kOwn * whole) span.add(column);
  }
  return span;
}

bool seeks_a_swing(const EffectDefinition& effect, unsigned kind) {
  // Of an effect whose wave repeats over the angle the first parameter is the wave's amplitude.
  return effect.parameters.size() == 2 &&
         effects::start_rule(effect, kind).search == effects::StartSearch::frequency;
}

// Of a wave of torque over the angle: it acts in a motor's equation.
bool seeks_a_torque(const EffectDefinition& effect, unsigned kind) {
  return effect.needs_base == effects::Base::motor &&
         effects::start_rule(effect, kind).search == effects::StartSearch::frequency;
}

double looks_for_a_swing() {
  return static_cast<double>(periods_s().size());
}

}  // namespace

std::vector<std::vector<double>> JointsProblem::starts(const Model& model,
                                                       const EffectDefinition& effect) const {
  const Groups training = folds().size() == 1 ? training_groups() : all_groups();
  return starts_seen_on(training, model, effect);
}

std::vector<std::vector<double>> JointsProblem::starts_on(const Groups& groups, const Model& model,
                                                          const EffectDefinition& effect,
                                                          const EffectList& companions) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  const bool looks = rule.values.empty() && rule.search != effects::StartSearch::motion;
  return looks ? starts_seen_on(groups, model, effect)
               : Problem::starts_on(groups, model, effect, companions);
}

std::vector<std::vector<double>> JointsProblem::starts_seen_on(
    const Groups& groups, const Model& model, const EffectDefinition& effect) const {
  if (seeks_a_swing(effect, facts_.set.kind)) return swing_seen(model, effect, groups);
  if (seeks_a_torque(effect, facts_.set.kind)) return torque_wave_seen(model, effect, groups);
  const auto few = few_of(*this, model, groups);
  if (!few || few->problem == this)
    return starts_of(model, effect, few ? few->groups : groups, groups);
  const auto& beginnings = static_cast<const JointsProblem&>(*few->problem);
  const auto begun = beginnings.starts_of(model, effect, groups, groups);
  // What the beginnings like best all rows must like; else they are asked themselves.
  constexpr double kPlain = 20;  // Units of likelihood.
  Model there = model;
  there.add_neutral(std::make_shared<EffectDefinition>(effect));
  for (size_t i = 0; i < begun.front().size(); ++i)
    there.set_value(effect.name, i, begun.front()[i]);
  const Score with = score(there, groups), without = score(model, groups);
  if (with.valid && with.log_likelihood > without.log_likelihood + kPlain) return begun;
  return starts_of(model, effect, groups, groups);
}

double span_of(const JointLogs& set) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const JointLog& log : set.logs) {
    for (const double q : log.measured_rad) least = std::min(least, q), most = std::max(most, q);
  }
  // Of a joint that hardly turns a coarse look.
  constexpr double kLeastSpan_rad = 0.1;
  return std::max(most - least, kLeastSpan_rad);
}

namespace {

// Residuals at their angles, and a wave over the angle that goes to higher frequencies by steps.
class WaveOverAngle {
 public:
  WaveOverAngle(std::vector<double> angle_rad, std::vector<double> residual)
      : angle_rad_(std::move(angle_rad)), residual_(std::move(residual)) {
    double sum = 0;
    for (const double r : residual_) sum += r;
    for (double& r : residual_) r -= sum / static_cast<double>(residual_.size());
  }

  // Begins at `cycles` a turn; each look goes on by `step`.
  void begin(double cycles, double step) {
    for (const double q : angle_rad_) {
      at_.emplace_back(maths::cos(cycles * q), maths::sin(cycles * q));
      turn_.emplace_back(maths::cos(step * q), maths::sin(step * q));
    }
  }

  // The wave by least squares beside a constant: by how much it lowers the sum of squares.
  double look() {
    std::complex<double> sum = 0, square = 0, with = 0;
    for (size_t k = 0; k < at_.size(); ++k) {
      sum += at_[k], square += at_[k] * at_[k], with += at_[k] * residual_[k];
      at_[k] *= turn_[k];
    }
    const auto n = static_cast<double>(at_.size());
    const double c = sum.real() / n, s = sum.imag() / n;
    const double cc = 0.5 * (n + square.real()) - n * c * c;
    const double ss = 0.5 * (n - square.real()) - n * s * s;
    const double sc = 0.5 * square.imag() - n * s * c, determinant = ss * cc - sc * sc;
    // A wave that the angles hardly show is taken for a constant.
    constexpr double kLeast = 1e-3;
    if (!(determinant > kLeast * n * n)) return 0;
    sine_ = (cc * with.imag() - sc * with.real()) / determinant;
    cosine_ = (ss * with.real() - sc * with.imag()) / determinant;
    return sine_ * with.imag() + cosine_ * with.real();
  }
  // Of the last look.
  double amplitude_rad() const { return std::hypot(sine_, cosine_); }
  double phase_rad() const { return maths::atan2(cosine_, sine_); }

 private:
  std::vector<double> angle_rad_, residual_;
  std::vector<std::complex<double>> at_, turn_;
  double sine_ = 0, cosine_ = 0;
};

}  // namespace

// As many as the joint's way separates over the range of frequencies, twice: between two of them
// a wave loses a third of its height at most.
double JointsProblem::looks(const Model& model, const EffectDefinition& effect) const {
  if (effects::start_rule(effect, facts_.set.kind).search != effects::StartSearch::frequency)
    return Problem::looks(model, effect);
  if (seeks_a_swing(effect, facts_.set.kind)) return looks_for_a_swing();
  const effects::Parameter& per_turn = effect.parameters[1];
  return std::max(1.0, (per_turn.max - per_turn.min) * span_of(set_) / maths::kPi);
}

std::vector<double> JointsProblem::wave_over_angle(const Model& model,
                                                   const effects::Parameter& per_turn,
                                                   const Groups& shown) const {
  const Evaluation here = evaluate(model, shown, nullptr);
  std::vector<double> angle_rad, residual;
  constexpr size_t kMostRows = 2000;
  const size_t every = 1 + facts_.rows() / kMostRows;
  for (const JointLog& log : set_.logs) {
    if (!shown[facts_.group_of_row[log.rows[0]]]) continue;
    for (size_t k = 0; k < log.rows.size(); k += every) {
      const size_t row = log.rows[k];
      if (left_out(row)) continue;
      residual.push_back(here.residual[row]);
      angle_rad.push_back(log.measured_rad[k] - here.residual[row]);
    }
  }
  std::vector<double> best = {0, per_turn.neutral, 0};
  if (angle_rad.empty()) return best;
  WaveOverAngle wave(std::move(angle_rad), std::move(residual));
  const double step = 0.5 * maths::kPi / span_of(set_);  // A quarter of the width of a wave's peak.
  wave.begin(per_turn.min, step);
  double gain = 0;
  for (double cycles = per_turn.min; cycles <= per_turn.max; cycles += step) {
    const double gained = wave.look();
    if (!(gained > gain)) continue;
    gain = gained;
    best = {wave.amplitude_rad(), cycles, wave.phase_rad()};
  }
  return best;
}

// The swing that would take most of what is left beside the model's own values, if a swing takes
// more than chance gives so many looks, and enough of what is left: while a model misses far more,
// what it misses comes first, and the look is had again when that is found.
std::vector<std::vector<double>> JointsProblem::swing_seen(const Model& model,
                                                           const EffectDefinition& effect,
                                                           const Groups& groups) const {
  constexpr double kByChance = 12;  // Of chi-square: one of thirty looks in a hundred sets.
  constexpr double kShare = 0.02;
  constexpr double kMost = 1.5;  // Times the whole swing.
  const Evaluation here = evaluate(model, groups, nullptr);
  if (!here.valid) return {};
  const Span values = span_of_values(*this, model, groups, here);
  std::vector<double> left = here.whitened;
  values.take_out_of(left);
  double gain = std::max(kByChance, kShare * dot(left, left));
  std::vector<std::vector<double>> best;
  Model trial = model;
  trial.add_neutral(std::make_shared<EffectDefinition>(effect));
  for (const double period_s : periods_s()) {
    for (const double damping : kDampings) {
      trial.set_value(effect.name, 0, period_s);
      trial.set_value(effect.name, 1, damping);
      const Evaluation there = evaluate(trial, groups, &here);
      if (!there.valid) continue;
      std::vector<double> change(left.size(), 0);
      for (size_t i = 0; i < change.size(); ++i) change[i] = here.whitened[i] - there.whitened[i];
      values.take_out_of(change);
      const double along = dot(left, change), square = dot(change, change);
      if (!(along > 0) || !(square > 0)) continue;
      const double part = std::min(along / square, kMost);
      const double gained = part * (2 * along - part * square);
      if (gained > gain) gain = gained, best = {{period_s, damping}};
    }
  }
  return best;
}

// A coarse look over the whole range of each servo parameter, on the groups that fits may see: the
// likelihood has several valleys (a speed limit that never binds, a latency of another row). The
// best of it comes first, then a small effect, from which other parameters can make way.
std::vector<std::vector<double>> JointsProblem::starts_of(const Model& model,
                                                          const EffectDefinition& effect,
                                                          Groups shown,
                                                          const Groups& training) const {
  const effects::StartRule& rule = effects::start_rule(effect, facts_.set.kind);
  if (!rule.values.empty()) return Problem::starts(model, effect);
  if (effect.spread_only)
    return {{largest_step_rad_ > 0 ? largest_step_rad_ : effect.parameters[0].scale}};
  if (rule.search == effects::StartSearch::motion) return starts_together(model, effect, {});
  if (rule.search == effects::StartSearch::frequency)
    return {wave_over_angle(model, effect.parameters[1], shown)};
  if (effect.parameters.empty() || (!effect.servo && !effect.logged))
    return Problem::starts(model, effect);
  const effects::Parameter& first = effect.parameters[0];
  std::vector<double> neutral;
  for (const effects::Parameter& p : effect.parameters) neutral.push_back(p.neutral);
  const bool wave = rule.search == effects::StartSearch::wave;
  const bool motor = effects::has_base(model, effects::Base::motor);
  const std::vector<std::vector<double>> grid = coarse_grid(effect, wave, motor);
  Model trial = model;
  trial.add_neutral(std::make_shared<EffectDefinition>(effect));
  Evaluation warm = evaluate(model, shown, nullptr);
  double best = std::numeric_limits<double>::infinity();
  std::vector<double> best_values = grid.front();
  const auto look = [&](const std::vector<double>& values) {
    for (size_t i = 0; i < values.size(); ++i) trial.set_value(effect.name, i, values[i]);
    const Evaluation evaluation = evaluate(trial, shown, &warm);
    const double cost = evaluation.valid ? -log_likelihood_of(*this, evaluation) : best;
    if (cost < best) best = cost, best_values = values;
  };
  for (const auto& values : grid) look(values);
  // The likelihood of a dead band jumps wherever one more move falls into it, so that no descent
  // leads to its best value: the look goes nearer, three times between the neighbours of the best
  // so far, the last time with all groups that a fit may see.
  if (effect.servo && !motor) {
    double ratio = kCoarse;
    constexpr int kNearer = 3;
    for (int nearer = 0; nearer < kNearer; ++nearer) {
      constexpr int kLooks = 12;  // To each side.
      const std::vector<double> centre = best_values;
      if (nearer == kNearer - 1 && shown != training) {
        shown = training;
        warm = evaluate(model, shown, nullptr);
        best = std::numeric_limits<double>::infinity();
        look(centre);
      }
      for (int k = -kLooks; k <= kLooks; ++k) {
        std::vector<double> values = centre;
        values[0] = std::clamp(centre[0] * std::pow(ratio, static_cast<double>(k) / kLooks),
                               first.min, first.max);
        if (k != 0) look(values);
      }
      ratio = std::pow(ratio, 2.0 / kLooks);
    }
  }
  std::vector<double> small = neutral;
  small[0] = first.fit_reciprocal ? 10 * first.scale : 0.2 * first.scale;
  return {best_values, small};
}

}  // namespace seam::measurement
