// The default fit: Levenberg-Marquardt on whitened residuals for parameters of the mean, Newton
// steps on the log-likelihood for parameters of the spread, in turn until neither moves.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/few_groups.h"
#include "measurement/fitting/spreads_together.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/problem/problem.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

// Errors above this, in noise units, are those of a model that explains nothing.
constexpr double kFarOff = 3;

double step_of(const effects::Parameter& parameter, double value) {
  const double size = std::max(parameter.scale, std::abs(value));
  const double step = 1e-4 * (std::isfinite(size) ? size : parameter.scale);
  return value + step > parameter.max ? -step : step;
}

double objective(const Problem& problem, const Evaluation& evaluation) {
  if (!evaluation.valid) return std::numeric_limits<double>::infinity();
  return -log_likelihood_of(problem, evaluation);
}

// The state of one fit.
class Fitter {
 public:
  Fitter(const Problem& problem, const Model& start, const std::vector<Unknown>& unknowns,
         const Groups& groups)
      : problem_(problem),
        groups_(groups),
        space_(start, unknowns),
        model_(start),
        here_(problem.evaluate(start, groups)) {
    value_ = objective(problem_, here_);
    for (size_t i = 0; i < unknowns.size(); ++i) {
      if (!space_[i].spread) mean_.push_back(unknowns[i]), mean_place_.push_back(i);
    }
    count_ = static_cast<size_t>(std::count(here_.used.begin(), here_.used.end(), 1));
  }

  Fit run() {
    const bool converged = go_down();
    return result(converged);
  }

  // Whether a few groups may lead the way: what a kind reuses from evaluation to evaluation is dear
  // to find anew.
  bool may_begin_with_few() const { return here_.valid && !here_.reusable; }
  // Begins where a fit to a few groups ended, if that is better here too.
  void begin_with(const Fitter& few) {
    Model model = few.model_;
    for (const Coordinate& c : space_) {
      // A spread that a few groups do not show may be there.
      if (c.spread && !(c.of(model) > kNoSpread * c.scale)) c.set(model, c.of(model_));
    }
    try_model(model);
  }

  bool go_down() {
    bool converged = mean_.empty();
    for (int round = 0; round < 6; ++round) {
      const double before = value_;
      if (!mean_.empty()) converged = fit_mean();
      fit_spread();
      const bool has_spread = mean_.size() < space_.size();
      constexpr double kRound = 10;  // Steps of which each is worth nothing.
      if ((!has_spread && !here_.reusable) || before - value_ < kRound * enough()) break;
      if (here_.reusable) renew();
    }
    return converged;
  }

 private:
  double enough() const;
  bool fit_mean();
  void fit_spread();
  // What evaluations reused on the way is computed again.
  void renew() {
    here_ = problem_.evaluate(model_, groups_);
    value_ = objective(problem_, here_);
  }
  void newton_spread(const Coordinate& c);
  Fit result(bool converged);
  bool try_model(const Model& candidate);
  Parabola look();

  const Problem& problem_;
  const Groups& groups_;
  const ParameterSpace space_;
  Model model_;
  Evaluation here_;
  double value_ = 0;  // Negative log-likelihood.
  SpreadsTogether together_;
  size_t count_ = 0;  // Residuals.
  std::vector<Unknown> mean_;
  std::vector<size_t> mean_place_;  // Among all unknowns.
};

// Parameters of the spread have no slope, and stay.
Parabola Fitter::look() {
  const Eigen::Map<const Eigen::VectorXd> z(here_.whitened.data(),
                                            static_cast<Eigen::Index>(here_.whitened.size()));
  Eigen::MatrixXd jacobian =
      Eigen::MatrixXd::Zero(z.size(), static_cast<Eigen::Index>(space_.size()));
  const auto columns = problem_.jacobian(model_, mean_, groups_, here_);
  const Eigen::VectorXd place = space_.place(model_);
  for (size_t k = 0; k < columns.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(mean_place_[k]);
    // A limit that never binds: the kind gives the derivative by its reciprocal.
    const double slope = space_[mean_place_[k]].slope(place[i]);
    jacobian.col(i) = (std::isfinite(slope) ? slope : 1) *
                      Eigen::Map<const Eigen::VectorXd>(columns[k].data(), z.size());
  }
  Parabola out = parabola_of(jacobian, z);
  out.held = space_.box().held(place, out.gradient);
  out.untold = space_.untold();
  return out;
}

bool Fitter::try_model(const Model& candidate) {
  Evaluation there = problem_.evaluate(candidate, groups_, &here_);
  const double value = objective(problem_, there);
  if (!(value < value_)) return false;
  value_ = value;
  model_ = candidate;
  here_ = std::move(there);
  return true;
}

// A gain of this much log-likelihood moves no estimate by more than a few hundredths of its sigma;
// where the model misses more than the noise, it is worth less in proportion.
double Fitter::enough() const {
  double sum = 0;
  for (const double z : here_.whitened) sum += z * z;
  const double misfit2 = sum / static_cast<double>(std::max<size_t>(1, count_));
  // A model that explains nothing need not be fitted to the last digit.
  return (misfit2 > kFarOff * kFarOff ? 1e-2 : 1e-4) * std::max(1.0, misfit2);
}

bool Fitter::fit_mean() {
  if (!here_.valid) return false;
  constexpr int kMostSteps = 40;
  const Work work("step", kMostSteps, Work::Of::at_most);
  const auto counted_look = [&] {
    work.done();
    return look();
  };
  const DescentEnd end = descend(
      {.look = counted_look,
       .move = [&](const Eigen::VectorXd& by) { return try_model(space_.moved(model_, by)); },
       .height = [&] { return value_; },
       .worth =
           [&] {
             const double least = enough();
             return Worth{.promise = least, .gain = least};
           }},
      {.start = 1e-6, .attempts = 12}, kMostSteps);
  if (end.reason == DescentEnd::Reason::refused) return end.promised < 100 * enough();
  return end.reason != DescentEnd::Reason::steps_spent;
}

void Fitter::fit_spread() {
  const size_t count = space_.size() - mean_.size();
  if (count == 0) return;
  together_ = fit_spreads_together(problem_, space_, model_, groups_, &here_, &together_);
  if (!together_.which.empty()) try_model(space_.at(model_, together_.place));
  for (int sweep = 0; sweep < (count > 1 ? 8 : 1); ++sweep) {
    const double before = value_;
    for (size_t i = 0; i < space_.size(); ++i) {
      if (space_[i].spread && !together_.has(i)) newton_spread(space_[i]);
    }
    if (before - value_ < 1e-4) break;
  }
}

// Newton in the square of a sigma, in which the likelihood is smooth at zero.
void Fitter::newton_spread(const Coordinate& c) {
  const auto at = [&](double square) {
    Model candidate = model_;
    c.set(candidate, std::clamp(std::sqrt(std::max(square, 0.0)), c.min, c.max));
    return candidate;
  };
  const auto cost = [&](double square) {
    return objective(problem_, problem_.evaluate(at(square), groups_, &here_));
  };
  for (int iteration = 0; iteration < 25; ++iteration) {
    const double value = c.of(model_);
    const double square = value * value;
    const double floor = 1e-3 * c.scale;
    const double h = 0.02 * std::max(square, floor * floor);
    const double base = std::max(square, h);
    const double below = cost(base - h), middle = cost(base), above = cost(base + h);
    const double slope = (above - below) / (2 * h);
    const double curvature = (above - 2 * middle + below) / (h * h);
    // Far from the optimum the curvature misleads: at most a factor of 6 a step.
    double next = curvature > 0 ? base - slope / curvature : (slope > 0 ? base / 6 : base * 6);
    next = std::clamp(next, base / 6, base * 6 + floor * floor);
    if (next < floor * floor) next = 0;
    const double before = value_;
    bool accepted = try_model(at(next));
    for (int half = 0; half < 6 && !accepted; ++half)
      accepted = try_model(at(square + (next - square) * std::pow(0.4, half + 1)));
    if (!accepted || before - value_ < 1e-3) break;
  }
}

Fit Fitter::result(bool converged) {
  const Eigen::VectorXd place = space_.place(model_);
  Fit fit = space_.fit_at(model_, place, -value_, converged && std::isfinite(value_));
  if (!here_.valid) return fit;
  if (!mean_.empty())
    space_.state(covariance_of(look().curvature, 1e-13), misfit_of(problem_, here_), place, fit);
  if (!together_.holds_at(-value_))
    together_ = fit_spreads_together(problem_, space_, model_, groups_, &here_, &together_);
  for (size_t i = 0; i < space_.size(); ++i) {
    if (!space_[i].spread || together_.has(i)) continue;
    const double sigma = spread_error(problem_, space_, i, model_, groups_, &here_, 0.05);
    space_.state(i, sigma, space_[i].of(model_), fit);
  }
  together_.state(fit);
  return fit;
}

}  // namespace

std::vector<std::vector<double>> Problem::following(
    const Model&, const Groups&, const Evaluation& here,
    std::vector<std::vector<double>> columns) const {
  constexpr double kSame = 1e-9;
  int64_t used = 0;
  for (size_t i = 0; i < facts_.scalars(); ++i) {
    used += here.used[i];
    if (here.used[i] && !(std::abs(here.whitened[i] - here.residual[i] / here.sigma[i]) <
                          kSame * (1 + std::abs(here.whitened[i]))))
      return {};
  }
  // A start for each run of many rows takes next to nothing of a function over all of them.
  constexpr int64_t kFew = 20;
  return kFew * here.nuisances <= used ? std::move(columns) : std::vector<std::vector<double>>();
}

std::unique_ptr<SmallChanges> Problem::small_changes(const Model&, const Groups& groups,
                                                     const Evaluation& here) const {
  struct ByEvaluation : SmallChanges {
    std::vector<double> to(const Model& there) const override {
      const Evaluation evaluation = problem.evaluate(there, groups, &here);
      if (!evaluation.valid) return {};
      std::vector<double> changes = evaluation.whitened;
      for (size_t i = 0; i < changes.size(); ++i) changes[i] -= here.whitened[i];
      return changes;
    }
    ByEvaluation(const Problem& of, const Groups& on, const Evaluation& at)
        : problem(of), groups(on), here(at) {}
    const Problem& problem;
    const Groups& groups;
    const Evaluation& here;
  };
  return std::make_unique<ByEvaluation>(*this, groups, here);
}

std::vector<std::vector<double>> Problem::jacobian(const Model& model,
                                                   const std::vector<Unknown>& unknowns,
                                                   const Groups& groups,
                                                   const Evaluation& here) const {
  std::vector<std::vector<double>> columns;
  for (const Unknown& unknown : unknowns) {
    const effects::ModelEffect& effect = *model.find(unknown.effect);
    const double value = effect.parameters[unknown.parameter].value;
    double step = step_of(effect.definition->parameters[unknown.parameter], value);
    Model moved = model;
    const auto evaluate_there = [&] {
      moved.set_value(unknown.effect, unknown.parameter, value + step);
      return evaluate(moved, groups, &here);
    };
    Evaluation there = evaluate_there();
    if (!there.valid) {
      step = -step;
      there = evaluate_there();
    }
    std::vector<double> column(facts_.scalars(), 0);
    for (size_t i = 0; i < column.size(); ++i) {
      if (here.used[i] && there.valid) column[i] = (there.whitened[i] - here.whitened[i]) / step;
    }
    columns.push_back(std::move(column));
  }
  return columns;
}

Fit Problem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                 const Groups& groups) const {
  Fitter fitter(*this, start, unknowns, groups);
  if (const auto few = few_of(*this, start, groups); few && fitter.may_begin_with_few()) {
    Fitter first(*few->problem, start, unknowns, few->groups);
    first.go_down();
    fitter.begin_with(first);
  }
  return fitter.run();
}

}  // namespace seam::measurement
