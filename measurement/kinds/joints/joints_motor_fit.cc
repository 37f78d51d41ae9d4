// Fits of servos with torque: whole runs are simulated, nearly smooth in all parameters.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "effects/questions.h"
#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/kinds/joints/motion_look.h"
#include "measurement/kinds/joints/short_runs.h"
#include "measurement/kinds/joints/torque/damped_motor.h"
#include "measurement/kinds/joints/torque/two_columns.h"
#include "measurement/numerics/linear_algebra.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

double misfit_under(const Problem& problem, const Model& model, const Groups& groups) {
  const Evaluation there = problem.evaluate(model, groups);
  return there.valid ? misfit_of(problem, there) : std::numeric_limits<double>::infinity();
}

namespace {

using Values = std::vector<double>;

double dot_of(const Values& a, const Values& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

// Principal axes of the errors of what moves the mean, in coordinates, each one error long.
std::vector<Eigen::VectorXd> axes_of(const Fit& fit, const ParameterSpace& space) {
  const Eigen::VectorXd place = space.place(fit.model);
  std::vector<Eigen::Index> known;
  for (size_t i = 0; i < space.size(); ++i) {
    const double slope = space[i].slope(place[static_cast<Eigen::Index>(i)]);
    const bool told = std::isfinite(fit.sigma[i]) && fit.sigma[i] > 0 && std::isfinite(slope);
    if (told && slope != 0 && !space[i].spread) known.push_back(static_cast<Eigen::Index>(i));
  }
  const auto count = static_cast<Eigen::Index>(known.size());
  Eigen::MatrixXd correlation(count, count);
  const auto size = static_cast<Eigen::Index>(space.size());
  for (Eigen::Index a = 0; a < count; ++a) {
    for (Eigen::Index b = 0; b < count; ++b)
      correlation(a, b) =
          fit.covariance[static_cast<size_t>(known[a] * size + known[b])] /
          (fit.sigma[static_cast<size_t>(known[a])] * fit.sigma[static_cast<size_t>(known[b])]);
  }
  std::vector<Eigen::VectorXd> axes;
  if (count == 0 || !correlation.allFinite()) return axes;
  const SymmetricEigen eigen = symmetric_eigen(correlation);
  for (Eigen::Index k = 0; k < count; ++k) {
    Eigen::VectorXd axis = Eigen::VectorXd::Zero(size);
    const double length = std::sqrt(std::max(0.0, eigen.values[k]));
    for (Eigen::Index a = 0; a < count; ++a) {
      const auto i = static_cast<size_t>(known[a]);
      axis[known[a]] =
          length * eigen.vectors(a, k) * fit.sigma[i] / space[i].slope(place[known[a]]);
    }
    axes.push_back(std::move(axis));
  }
  return axes;
}

// A fit of some unknowns as one of all, of which the others stay where they are.
Fit with_waiting(const Fit& fit, const std::vector<Unknown>& some,
                 const std::vector<Unknown>& unknowns) {
  std::vector<size_t> place;  // Of these among all.
  for (const Unknown& one : some) place.push_back(index_of(unknowns, one).value());
  const ParameterSpace space(fit.model, unknowns);
  Fit told = space.fit_at(fit.model, space.place(fit.model), fit.log_likelihood, fit.converged);
  told.sigma.assign(unknowns.size(), 0);
  for (size_t i = 0; i < place.size(); ++i) {
    told.sigma[place[i]] = fit.sigma[i], told.at_bound[place[i]] = fit.at_bound[i];
    for (size_t k = 0; k < place.size(); ++k)
      told.covariance[place[i] * unknowns.size() + place[k]] = fit.covariance[i * some.size() + k];
  }
  return told;
}

// Of these models the one that misses least; none of none.
std::optional<Model> nearest(const std::vector<Model>& models,
                             const std::function<double(const Model&)>& misfit_of) {
  std::optional<Model> best;
  double least = std::numeric_limits<double>::infinity();
  for (const Model& model : models) {
    const double there = misfit_of(model);
    if (there < least) least = there, best = model;
  }
  return best;
}

// The model with white noise alone: errors that hang together stand for whatever its mean lacks.
Model with_white_noise(Model model) {
  std::vector<std::string> out;
  for (const effects::ModelEffect& effect : model.effects()) {
    if (effect.definition->errors == effects::Errors::together)
      out.push_back(effect.definition->name);
  }
  for (const std::string& name : out) model.remove(name);
  return model;
}

// The controller's damping comes for what chance gains once in a thousand sets.
constexpr double kAskedFor = 5.4, kAtNoise = 1.03;
// A model that misses by so much more than the noise is in no valley yet.
constexpr double kFar = 100;

// The unknowns of effects that change something, less what waits until the data ask for it.
std::vector<Unknown> acting(const Model& model, const std::vector<Unknown>& unknowns) {
  std::vector<Unknown> some;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *model.find(unknown.effect);
    bool idle = effect.definition->has_neutral;
    for (size_t i = 0; i < effect.parameters.size(); ++i)
      idle = idle && effect.parameters[i].value == effect.definition->parameters[i].neutral;
    if (!idle && is_open(effect, unknown.parameter)) some.push_back(unknown);
  }
  return some;
}

}  // namespace

bool is_open(const effects::ModelEffect& effect, size_t i) {
  const effects::Parameter& parameter = effect.definition->parameters[i];
  const bool waits = parameter.on_demand && effect.parameters[i].value == parameter.neutral;
  return !waits && (!parameter.stated || effect.parameters[i].refitted());
}

// Of a limit that few rows feel accelerations show next to nothing, and what a whole run loses by
// it does not: from where it begins to act it comes down until it costs more than it gains.
std::optional<double> JointsProblem::limit_that_helps(const Model& model,
                                                      const EffectDefinition& effect,
                                                      const Groups& groups) const {
  constexpr double kNear = 1.5, kHelps = 0.9999, kWorse = 1.1, kCoarse = 1.1, kFine = 1.01;
  constexpr double kMost = 300, kLeast = 0.1;  // In units of its scale.
  const effects::Parameter& parameter = effect.parameters.front();
  if (effect.parameters.size() > 1 || !parameter.fit_reciprocal) return std::nullopt;
  const auto cost_at = [&](double size) {
    Model there = model;
    there.set_value(effect.name, 0, size * parameter.scale);
    return misfit_under(*this, there, groups);
  };
  const double here = misfit_under(*this, model, groups);
  if (!(here < kNear)) return std::nullopt;
  double size = kMost;
  while (size > kLeast && cost_at(size) == here) size /= kCoarse;
  double least = kHelps * here;
  std::optional<double> best;
  for (size *= kCoarse; size > kLeast; size /= kFine) {
    const double cost = cost_at(size);
    if (!(cost < kWorse * here)) break;
    if (cost < least) least = cost, best = size * parameter.scale;
  }
  return best;
}

// A joint that sticks a moment longer or shorter makes the likelihood rough where slopes see it
// smooth: steps along the axes of what the fit holds for possible find better places.
Fit JointsProblem::polished(Fit fit, const std::vector<Unknown>& unknowns,
                            const Groups& groups) const {
  constexpr double kNear = 3, kWorth = 1;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const ParameterSpace space(fit.model, unknowns);
    const auto axes = axes_of(fit, space);
    const Evaluation found = evaluate(fit.model, groups, nullptr);
    const double misfit = found.valid ? misfit_of(*this, found) : kNear;
    if (axes.empty() || !(misfit < kNear)) return fit;
    Model best = fit.model;
    double most = log_likelihood_of(*this, found);
    const double before = most;
    for (const double width : {4.0, 1.0}) {
      for (const Eigen::VectorXd& axis : axes) {
        for (const double by : {width, -width}) {
          const Model there = space.moved(best, by * axis);
          const Score score = score_of(*this, evaluate(there, groups, nullptr));
          if (!score.valid || !(score.log_likelihood > most)) continue;
          most = score.log_likelihood, best = there;
          break;
        }
      }
    }
    if (most - before < kWorth * misfit * misfit) return fit;
    fit = Problem::fit(best, unknowns, groups);
  }
  return fit;
}

// A model with the controller's own damping that is the better beginning, by short stretches of the
// log after a descent on its accelerations.
std::optional<Model> JointsProblem::worth_damping(const Fit& fit, const std::vector<Unknown>& first,
                                                  const std::vector<Unknown>& unknowns,
                                                  const Groups& groups) const {
  constexpr double kBetter = 0.9, kStretch_s = 0.3, kMoves = 1e-3;
  const std::vector<Model> others = damped_otherwise(fit.model);
  if (others.empty()) return std::nullopt;
  const auto misfit_at = [&](const Model& model) { return misfit_under(*this, model, groups); };
  const double here = misfit_at(fit.model);
  std::vector<double> there;
  for (const Model& other : others) there.push_back(misfit_at(other));
  // Where nothing saturates damping is back-EMF by another name.
  if (std::all_of(there.begin(), there.end(),
                  [&](double misfit) { return std::abs(misfit - here) < kMoves * here; }))
    return std::nullopt;
  const std::vector<char> chosen = logs_of(groups);
  const MotionLook look = motion_look(fit.model, chosen);
  const ShortRuns brief(set_, chosen, kStretch_s);
  Model plain = fit.model;
  look.descend(plain, first);
  double least = kBetter * std::min(brief.cost(plain), brief.cost(fit.model));
  std::optional<Model> best;
  for (Model other : others) {
    look.descend(other, unknowns);
    const double cost = brief.cost(other);
    if (cost < least) least = cost, best = std::move(other);
  }
  return best;
}

// From this model, of what changes something in it.
Fit JointsProblem::fit_acting(const Model& start, const std::vector<Unknown>& unknowns,
                              const Groups& groups) const {
  const std::vector<Unknown> some = acting(start, unknowns);
  return with_waiting(polished(Problem::fit(start, some, groups), some, groups), some, unknowns);
}

// What the data must ask for waits until all else is fitted, and comes where it gains what chance
// gives once in a thousand sets. Far from the noise it would only stand in for what is missing.
Fit JointsProblem::fit_torque(const Model& start, const std::vector<Unknown>& unknowns,
                              const Groups& groups) const {
  constexpr double kNear = 10, kMuchLess = 0.5, kSame = 1.0001;
  std::vector<Unknown> first;
  for (const Unknown& unknown : unknowns) {
    if (is_open(*start.find(unknown.effect), unknown.parameter)) first.push_back(unknown);
  }
  const auto settled = [&](const Model& from, const std::vector<Unknown>& which) {
    return polished(Problem::fit(from, which, groups), which, groups);
  };
  const auto misfit_at = [&](const Model& model) { return misfit_under(*this, model, groups); };
  Fit fit = settled(near_start(start, first, groups), first);
  double misfit = misfit_at(fit.model);
  const auto take_if_better = [&](const Model& from) {
    Fit other = settled(from, first);
    if (other.log_likelihood > fit.log_likelihood)
      fit = std::move(other), misfit = misfit_at(fit.model);
  };
  if (misfit > kAtNoise && misfit < kFar) {
    if (const auto traded = trade_that_helps(fit.model, first, misfit_at)) take_if_better(*traded);
    if (const auto other = nearest(cut_off_otherwise(fit.model, first), misfit_at))
      take_if_better(*other);
  }
  // A limit and viscous friction beside it say nothing that the controller's damping does not.
  if (const auto same = damped_alike(fit.model); same && misfit_at(*same) < kSame * misfit)
    return fit_acting(*same, unknowns, groups);
  if (first.size() == unknowns.size()) return fit;
  const bool near = misfit > kAtNoise && misfit < kNear;
  std::optional<Model> damped;
  if (misfit < kFar) damped = worth_damping(fit, first, unknowns, groups);
  if (near || damped) {
    Fit all = settled(damped ? *damped : fit.model, unknowns);
    // Friction by load feels a drag behind the saturation as it feels none outside: no damped motor
    // moves as the limited one does, but one may move as the log says.
    if (const auto other = nearest(damped_within_limit(fit.model), misfit_at); near && other) {
      Fit within = fit_acting(*other, unknowns, groups);
      if (within.log_likelihood > all.log_likelihood) all = std::move(within);
    }
    const double gained = all.log_likelihood - fit.log_likelihood;
    const bool asked_for = gained > kAskedFor * misfit * misfit && keeps_back_emf(all, unknowns);
    if (asked_for && (near || misfit_at(all.model) < kMuchLess * misfit)) return all;
  }
  return with_waiting(fit, first, unknowns);
}

// Damping that was asked for while something else was missing goes where no back-EMF stays beside
// it: the model then lacks a limit of torque. Where nothing is missing without it either, the data
// ask for it.
Fit JointsProblem::fit_motor(const Model& start, const std::vector<Unknown>& unknowns,
                             const Groups& groups) const {
  Fit fit = fit_torque(start, unknowns, groups);
  const auto misfit_at = [&](const Model& model) { return misfit_under(*this, model, groups); };
  if (const double misfit = misfit_at(fit.model); misfit > kAtNoise && misfit < kFar) {
    if (const auto other = nearest(limited_otherwise(fit.model), misfit_at)) {
      Fit limited = fit_acting(*other, unknowns, groups);
      if (limited.log_likelihood > fit.log_likelihood) return limited;
    }
  }
  const auto without = keeps_back_emf(fit, unknowns) ? std::nullopt : undamped(fit.model, unknowns);
  if (!without) return fit;
  Fit other = fit_torque(*without, unknowns, groups);
  const bool complete = misfit_under(*this, with_white_noise(other.model), groups) < kAtNoise;
  return complete && fit.log_likelihood - other.log_likelihood > kAskedFor ? fit : other;
}

// Accelerations say how many waves a turn has, roughly; short stretches of the logs say which of
// these it is, how strong, and where.
std::vector<std::vector<double>> JointsProblem::torque_wave_seen(const Model& model,
                                                                 const EffectDefinition& effect,
                                                                 const Groups& groups) const {
  constexpr double kStretch_s = 0.3, kShare = 0.05;
  constexpr size_t kPeaks = 5;
  const effects::Parameter& per_turn = effect.parameters[1];
  const std::vector<char> chosen = logs_of(groups);
  const MotionLook look(set_, chosen, facts_.channels[0].noise, true);
  const double step = 0.5 * maths::kPi / span_of(set_);
  const ShortRuns brief(set_, chosen, kStretch_s);
  const std::vector<double> left = brief.misses(model);
  double gain = kShare * dot_of(left, left);
  if (!std::isfinite(gain)) return {};
  std::vector<std::vector<double>> best;
  Model trial = model;
  trial.add_neutral(std::make_shared<EffectDefinition>(effect));
  const auto change = [&](double waves, double phase_rad) {
    const double by = effect.parameters[0].scale;
    trial.set_value(effect.name, 0, by);
    trial.set_value(effect.name, 1, waves);
    trial.set_value(effect.name, 2, phase_rad);
    std::vector<double> column = brief.misses(trial);
    for (size_t i = 0; i < column.size(); ++i) column[i] = (left[i] - column[i]) / by;
    return column;
  };
  for (const double waves : look.torque_waves(model, per_turn.min, per_turn.max, step, kPeaks)) {
    const std::vector<double> sine = change(waves, 0), cosine = change(waves, 0.5 * maths::kPi);
    const TwoColumns fit =
        least_squares(dot_of(sine, sine), dot_of(sine, cosine), dot_of(cosine, cosine),
                      dot_of(sine, left), dot_of(cosine, left));
    if (!(fit.gain > gain)) continue;
    gain = fit.gain;
    best = {{std::hypot(fit.sine, fit.cosine), waves, maths::atan2(fit.cosine, fit.sine)}};
  }
  if (best.empty()) return {};
  // The waves lie between two that were looked at.
  std::vector<Unknown> own;
  for (size_t i = 0; i < best[0].size(); ++i) {
    trial.set_value(effect.name, i, best[0][i]);
    own.push_back({effect.name, i});
  }
  const Model nearer = brief.descend(trial, own);
  const effects::Values values = nearer.find(effect.name)->values();
  return {{values.begin(), values.end()}};
}

}  // namespace seam::measurement
