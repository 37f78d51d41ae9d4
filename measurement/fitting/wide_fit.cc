#include "measurement/fitting/wide_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/few_groups.h"
#include "measurement/fitting/spreads_together.h"
#include "measurement/numerics/damped_step.h"
#include "sim_core/system/work_tally.h"

namespace seam::measurement {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class WideFitter {
 public:
  WideFitter(const Problem& problem, const Model& start, const std::vector<Unknown>& unknowns,
             const Groups& groups)
      : problem_(problem),
        groups_(groups),
        model_(start),
        space_(start, unknowns),
        free_(unknowns.size(), 1),
        z_(space_.place(start)) {
    for (const Coordinate& c : space_) step_.push_back(1e-2 * c.scale);
    here_ = problem.evaluate(at(z_), groups);
    cost_ = cost_of(here_);
  }

  Fit run() {
    search();
    return result();
  }

  // Begins where a fit to a few groups ended, if that is better here too.
  void begin_with(const WideFitter& few) {
    Vector z = few.z_;
    for (size_t i = 0; i < space_.size(); ++i) {
      // A spread that a few groups do not show may be there.
      if (space_[i].spread && !(z[index(i)] > kNoSpread * space_[i].scale))
        z[index(i)] = z_[index(i)];
    }
    if (move_to(z)) step_ = few.step_;
  }

  void search() {
    // Parameters that the data must ask for wait until all else is fitted.
    std::vector<size_t> waiting;
    for (size_t i = 0; i < space_.size(); ++i) {
      const effects::Parameter& p = *space_[i].parameter;
      if (p.on_demand && z_[index(i)] == p.neutral) waiting.push_back(i), free_[i] = 0;
    }
    go_down();
    for (const size_t i : waiting) try_on_demand(i);
  }

  std::vector<std::vector<double>> derivatives() {
    const Eigen::MatrixXd j = jacobian();
    std::vector<std::vector<double>> columns;
    for (size_t i = 0; i < space_.size(); ++i) {
      const double slope = space_[i].slope(z_[index(i)]);
      columns.emplace_back(static_cast<size_t>(j.rows()));
      for (Eigen::Index k = 0; k < j.rows(); ++k)
        columns.back()[k] = j(k, index(i)) / (std::isfinite(slope) ? slope : 1);
    }
    return columns;
  }

 private:
  using Vector = Eigen::VectorXd;

  static Eigen::Index index(size_t i) { return static_cast<Eigen::Index>(i); }
  Model at(const Vector& z) const { return space_.at(model_, z); }

  // Minus twice the log-likelihood.
  double cost_of(const Evaluation& evaluation) const {
    if (!evaluation.valid) return kInfinity;
    const double cost = -2 * log_likelihood_of(problem_, evaluation);
    return std::isfinite(cost) ? cost : kInfinity;
  }
  // What a difference of the cost by 1 means at the noise: where the model misses by more, gains
  // are worth less in proportion, and a descent ends sooner.
  double unit() const {
    double sum = 0, count = 0;
    for (size_t i = 0; i < here_.whitened.size(); ++i) {
      if (here_.used[i]) sum += here_.whitened[i] * here_.whitened[i], ++count;
    }
    return count > 0 && std::isfinite(sum) ? std::max(1.0, sum / count) : 1;
  }
  double cost_at(const Vector& z) const {
    return cost_of(problem_.evaluate(at(z), groups_, &here_));
  }

  bool move_to(const Vector& z) {
    Evaluation there = problem_.evaluate(at(z), groups_, &here_);
    const double cost = cost_of(there);
    if (!(cost < cost_)) return false;
    cost_ = cost, z_ = z, here_ = std::move(there);
    return true;
  }

  Vector moved(size_t i, double by) const {
    Vector z = z_;
    z[index(i)] = std::clamp(z_[index(i)] + by, space_[i].min, space_[i].max);
    return z;
  }
  double least_step(size_t i) const { return 1e-6 * space_[i].scale; }

  Eigen::MatrixXd jacobian();
  void take_column(size_t i, Eigen::Ref<Vector> column);
  Parabola look();
  void levenberg_marquardt();
  bool pattern_search();
  void walk_spread(size_t i);
  // Where the data are as likely without it.
  void drop_spread(size_t i);
  void go_down();
  void try_on_demand(size_t i);
  double flat_width(size_t i, double sigma);
  Fit result();

  const Problem& problem_;
  const Groups& groups_;
  const Model model_;
  const ParameterSpace space_;
  std::vector<double> step_;  // Of differences.
  std::vector<char> free_;
  Vector z_;
  Evaluation here_;
  double cost_ = 0;
  SpreadsTogether together_;
};

Eigen::MatrixXd WideFitter::jacobian() {
  Eigen::MatrixXd jacobian =
      Eigen::MatrixXd::Zero(index(here_.whitened.size()), index(space_.size()));
  for (size_t i = 0; i < space_.size(); ++i) {
    if (free_[i] && !space_[i].spread) take_column(i, jacobian.col(index(i)));
  }
  return jacobian;
}

// Central differences over a step that is widened until the residuals notice it, then brought to
// about half a standard deviation of the parameter.
void WideFitter::take_column(size_t i, Eigen::Ref<Vector> column) {
  double& step = step_[i];
  const double most = 0.25 * (space_[i].max - space_[i].min), least = least_step(i);
  // A step that the residuals noticed, in case a narrower one slips between their steps.
  double noticed = 0;
  Vector noticed_column;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const Vector up = moved(i, step), down = moved(i, -step);
    const double span = up[index(i)] - down[index(i)];
    if (!(span > 0)) return;
    const Evaluation a = problem_.evaluate(at(up), groups_, &here_),
                     b = problem_.evaluate(at(down), groups_, &here_);
    if (!a.valid || !b.valid) {
      step *= 0.3;
      continue;
    }
    for (Eigen::Index k = 0; k < column.size(); ++k)
      column[k] = (a.whitened[k] - b.whitened[k]) / span;
    const double norm = column.norm();
    if (norm == 0 && noticed > 0) {
      step = noticed;
      column = noticed_column;
      return;
    }
    if (norm > 0) noticed = step, noticed_column = column;
    const double wish = norm > 0 ? 0.5 / norm : kInfinity;
    if (step < 0.2 * wish && step < most) {
      step = std::min({wish, 8 * step, most});
    } else if (step > 5 * wish && step > least) {
      step = std::max({wish, step / 8, least});
    } else {
      return;
    }
  }
}

Parabola WideFitter::look() {
  const Eigen::Map<const Vector> r(here_.whitened.data(), index(here_.whitened.size()));
  Parabola out = parabola_of(jacobian(), r);
  out.held = space_.box().held(z_, out.gradient);
  return out;
}

void WideFitter::levenberg_marquardt() {
  constexpr int kMostSteps = 25;
  const Work work("step", kMostSteps, Work::Of::at_most);
  const auto counted_look = [&] {
    work.done();
    return look();
  };
  descend({.look = counted_look,
           .move = [&](const Vector& by) { return move_to(space_.box().inside(z_ + by)); },
           .height = [&] { return 0.5 * cost_; },
           .worth = [&] { return Worth{.gain = 0.5e-3 * unit()}; }},
          {.start = 1e-4, .shrink = 0.2, .firm = 1e-3, .attempts = 7}, kMostSteps);
}

// Steps along each coordinate, wide to narrow; true where it found a clearly better place.
bool WideFitter::pattern_search() {
  const double before = cost_;
  for (const double width : {16.0, 4.0, 1.0}) {
    for (size_t i = 0; i < space_.size(); ++i) {
      if (!free_[i] || space_[i].spread) continue;
      for (const double sign : {1.0, -1.0}) {
        for (int repeat = 0; repeat < 8; ++repeat) {
          const Vector z = moved(i, sign * width * step_[i]);
          if (z == z_ || !move_to(z)) break;
        }
      }
    }
  }
  return before - cost_ > 0.5 * unit();
}

// Factors on a sigma, wide to narrow.
void WideFitter::walk_spread(size_t i) {
  for (const double factor : {3.0, 1.3, 1.05, 1.01}) {
    for (const double by : {factor, 1 / factor}) {
      for (int repeat = 0; repeat < 6; ++repeat) {
        const double z = std::max(z_[i], 1e-3 * space_[i].parameter->scale);
        const Vector next = moved(i, z * by - z_[i]);
        if (next == z_ || !move_to(next)) break;
      }
    }
  }
}

void WideFitter::drop_spread(size_t i) {
  Vector absent = z_;
  absent[i] = space_[i].parameter->neutral;
  if (cost_at(absent) <= cost_ + 1e-6) {
    here_ = problem_.evaluate(at(absent), groups_, &here_);
    z_ = absent, cost_ = cost_of(here_);
  }
}

void WideFitter::go_down() {
  for (int round = 0; round < 4; ++round) {
    levenberg_marquardt();
    together_ = fit_spreads_together(problem_, space_, at(z_), groups_, &here_, &together_);
    if (!together_.which.empty()) move_to(together_.place);
    for (size_t i = 0; i < space_.size(); ++i) {
      if (!free_[i] || !space_[i].spread) continue;
      if (!together_.has(i)) walk_spread(i);
      drop_spread(i);
    }
    if (!pattern_search()) return;
  }
}

void WideFitter::try_on_demand(size_t i) {
  // Asked for: a likelihood ratio that chance gives once in a thousand sets.
  constexpr double kAskedFor = 10.8;
  const Vector z0 = z_;
  const Evaluation here0 = here_;
  const double cost0 = cost_;
  Vector best_z = z_;
  double best = cost_;
  const Coordinate& c = space_[i];
  for (const double share : {0.2, 0.4, 0.6, 0.8}) {
    z_ = z0;
    z_[i] = c.min + share * (c.max - c.min);
    here_ = problem_.evaluate(at(z_), groups_);
    cost_ = cost_of(here_);
    free_[i] = 1;
    go_down();
    if (cost_ < best) best = cost_, best_z = z_;
  }
  const bool asked = cost0 - best > kAskedFor * unit();
  free_[i] = asked;
  z_ = asked ? best_z : z0;
  here_ = asked ? problem_.evaluate(at(z_), groups_) : here0;
  cost_ = asked ? best : cost0;
}

// Where the likelihood is flat (a latency between two rows) the estimate is the middle of the flat
// part, and its uncertainty that of a uniform distribution; 0 where the quadratic holds.
double WideFitter::flat_width(size_t i, double sigma) {
  const Coordinate& c = space_[i];
  const double one = unit();
  sigma *= std::sqrt(one);
  const auto rise = [&](double by) {
    const Vector z = moved(i, by);
    return z[i] == z_[i] ? kInfinity : (cost_at(z) - cost_) / one;
  };
  if (rise(sigma) > 0.3 && rise(-sigma) > 0.3) return 0;
  double edge[2] = {0, 0};
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? -1 : 1;
    double inside = 0, outside = std::max(sigma, least_step(i));
    while (rise(sign * outside) < 1 && outside < c.max - c.min) inside = outside, outside *= 2;
    for (int halving = 0; halving < 12; ++halving) {
      const double middle = 0.5 * (inside + outside);
      (rise(sign * middle) < 1 ? inside : outside) = middle;
    }
    edge[side] = sign * inside;
  }
  const Vector middle = moved(i, 0.5 * (edge[0] + edge[1]));
  const double cost = cost_at(middle);
  if (cost - cost_ < 0.5 * one) {
    const bool better = cost_ - cost > one;
    z_ = middle;
    here_ = problem_.evaluate(at(z_), groups_);
    cost_ = cost;
    // The edges were those of a worse place, far beyond this one's.
    if (better) return flat_width(i, sigma / std::sqrt(one));
  }
  return (edge[1] - edge[0]) / std::sqrt(12.0);
}

Fit WideFitter::result() {
  Covariance covariance;
  if (std::isfinite(cost_)) {
    const Eigen::MatrixXd information = look().curvature;
    covariance = covariance_of(information, 1e-12);
    const double misfit = misfit_of(problem_, here_);
    covariance.matrix *= misfit * misfit;
    for (size_t i = 0; i < space_.size(); ++i) {
      if (!covariance.known[i] || !free_[i]) continue;
      double& variance = covariance.matrix(index(i), index(i));
      const double flat = flat_width(i, 1 / std::sqrt(information(index(i), index(i))));
      variance = std::max(variance, flat * flat);
    }
  }
  const Model model = at(z_);
  Fit fit = space_.fit_at(model, z_, -0.5 * cost_, std::isfinite(cost_));
  if (!std::isfinite(cost_)) return fit;
  space_.state(covariance, 1, z_, fit);
  if (!together_.holds_at(-0.5 * cost_))
    together_ = fit_spreads_together(problem_, space_, model, groups_, &here_, &together_);
  for (size_t i = 0; i < space_.size(); ++i) {
    if (!free_[i]) {
      fit.sigma[i] = 0;
    } else if (space_[i].spread && !together_.has(i)) {
      const double sigma = spread_error(problem_, space_, i, model, groups_, &here_, 0.05);
      space_.state(i, sigma, z_[index(i)], fit);
    }
  }
  together_.state(fit);
  return fit;
}

}  // namespace

std::vector<std::vector<double>> wide_jacobian(const Problem& problem, const Model& model,
                                               const std::vector<Unknown>& unknowns,
                                               const Groups& groups) {
  return WideFitter(problem, model, unknowns, groups).derivatives();
}

Fit wide_fit(const Problem& problem, const Model& start, const std::vector<Unknown>& unknowns,
             const Groups& groups) {
  WideFitter fitter(problem, start, unknowns, groups);
  if (const auto few = few_of(problem, start, groups)) {
    WideFitter first(*few->problem, start, unknowns, few->groups);
    first.search();
    fitter.begin_with(first);
  }
  return fitter.run();
}

}  // namespace seam::measurement
