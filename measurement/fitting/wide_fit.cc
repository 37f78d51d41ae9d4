#include "measurement/fitting/wide_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One unknown in the coordinate in which it is fitted.
struct Coordinate {
  Unknown unknown;
  const effects::Parameter* parameter;
  double min, max;  // Bounds of the coordinate.
  double step;      // Of differences.
  double least_step;
  bool spread;  // Of a sigma: it has no slope in the residuals, only a likelihood.

  explicit Coordinate(const Model& model, const Unknown& u)
      : unknown(u), parameter(&model.find(u.effect)->definition->parameters[u.parameter]) {
    const effects::Parameter& p = *parameter;
    min = p.fit_reciprocal ? 0 : p.min;
    max = p.fit_reciprocal ? 1 / p.min : p.max;
    const double scale = p.fit_reciprocal ? 1 / p.scale : p.scale;
    step = 1e-2 * scale;
    least_step = 1e-6 * scale;
    spread = model.find(u.effect)->definition->spread_only;
  }
  double to_value(double z) const {
    return parameter->fit_reciprocal ? (z > 0 ? 1 / z : kInfinity) : z;
  }
  double from_value(double value) const {
    const double z = parameter->fit_reciprocal ? 1 / value : value;
    return std::clamp(z, min, max);
  }
};

class WideFitter {
 public:
  WideFitter(const Problem& problem, const Model& start, const std::vector<Unknown>& unknowns,
             const Groups& groups)
      : problem_(problem), groups_(groups), model_(start) {
    for (const Unknown& unknown : unknowns) coordinates_.emplace_back(start, unknown);
    const size_t count = unknowns.size();
    z_.resize(count);
    for (size_t i = 0; i < count; ++i) {
      z_[i] = coordinates_[i].from_value(
          start.find(unknowns[i].effect)->parameters[unknowns[i].parameter].value);
    }
    free_.assign(count, 1);
    here_ = problem.evaluate(at(z_), groups);
    cost_ = cost_of(here_);
  }

  Fit run() {
    // Parameters that the data must ask for wait until all else is fitted.
    std::vector<size_t> waiting;
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      const effects::Parameter& p = *coordinates_[i].parameter;
      if (p.on_demand && z_[i] == p.neutral) waiting.push_back(i), free_[i] = 0;
    }
    descend();
    for (const size_t i : waiting) try_on_demand(i);
    return result();
  }

  std::vector<std::vector<double>> derivatives() {
    const Eigen::MatrixXd j = jacobian();
    std::vector<std::vector<double>> columns;
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      const double value = coordinates_[i].to_value(z_[i]);
      const bool reciprocal = coordinates_[i].parameter->fit_reciprocal && std::isfinite(value);
      const double slope = reciprocal ? -1 / (value * value) : 1;
      columns.emplace_back(static_cast<size_t>(j.rows()));
      for (Eigen::Index k = 0; k < j.rows(); ++k) columns.back()[k] = slope * j(k, i);
    }
    return columns;
  }

 private:
  using Vector = Eigen::VectorXd;

  Model at(const Vector& z) const {
    Model model = model_;
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      const Coordinate& c = coordinates_[i];
      model.set_value(c.unknown.effect, c.unknown.parameter, c.to_value(z[i]));
    }
    return model;
  }

  // Minus twice the log-likelihood.
  double cost_of(const Evaluation& evaluation) const {
    if (!evaluation.valid) return kInfinity;
    const double cost = -2 * score_of(problem_, evaluation).log_likelihood;
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
    z[i] = std::clamp(z[i] + by, coordinates_[i].min, coordinates_[i].max);
    return z;
  }

  Eigen::MatrixXd jacobian();
  void levenberg_marquardt();
  bool pattern_search();
  void fit_spread(size_t i);
  void descend();
  void try_on_demand(size_t i);
  double flat_width(size_t i, double sigma);
  Fit result();

  const Problem& problem_;
  const Groups& groups_;
  Model model_;
  std::vector<Coordinate> coordinates_;
  std::vector<char> free_;
  Vector z_;
  Evaluation here_;
  double cost_ = 0;
};

// Central differences over a step that is widened until the residuals notice it, then brought to
// about half a standard deviation of the parameter.
Eigen::MatrixXd WideFitter::jacobian() {
  const size_t n = here_.whitened.size();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(n, coordinates_.size());
  for (size_t i = 0; i < coordinates_.size(); ++i) {
    Coordinate& c = coordinates_[i];
    if (!free_[i] || c.spread) continue;
    // A step that the residuals noticed, in case a narrower one slips between their steps.
    double noticed = 0;
    Vector noticed_column;
    for (int attempt = 0; attempt < 12; ++attempt) {
      const Vector up = moved(i, c.step), down = moved(i, -c.step);
      const double span = up[i] - down[i];
      if (!(span > 0)) break;
      const Evaluation a = problem_.evaluate(at(up), groups_, &here_),
                       b = problem_.evaluate(at(down), groups_, &here_);
      if (!a.valid || !b.valid) {
        c.step *= 0.3;
        continue;
      }
      for (size_t k = 0; k < n; ++k) jacobian(k, i) = (a.whitened[k] - b.whitened[k]) / span;
      const double norm = jacobian.col(i).norm();
      if (norm == 0 && noticed > 0) {
        c.step = noticed;
        jacobian.col(i) = noticed_column;
        break;
      }
      if (norm > 0) noticed = c.step, noticed_column = jacobian.col(i);
      const double wish = norm > 0 ? 0.5 / norm : kInfinity;
      if (c.step < 0.2 * wish && c.step < 0.25 * (c.max - c.min)) {
        c.step = std::min({wish, 8 * c.step, 0.25 * (c.max - c.min)});
      } else if (c.step > 5 * wish && c.step > c.least_step) {
        c.step = std::max({wish, c.step / 8, c.least_step});
      } else {
        break;
      }
    }
  }
  return jacobian;
}

void WideFitter::levenberg_marquardt() {
  double damping = 1e-4;
  for (int iteration = 0; iteration < 25; ++iteration) {
    const Eigen::MatrixXd j = jacobian();
    const Eigen::Map<const Vector> r(here_.whitened.data(),
                                     static_cast<Eigen::Index>(here_.whitened.size()));
    const Eigen::MatrixXd hessian = j.transpose() * j;
    const Vector gradient = j.transpose() * r;
    const double before = cost_;
    bool accepted = false;
    for (int attempt = 0; attempt < 7 && !accepted; ++attempt) {
      Eigen::MatrixXd damped = hessian;
      Vector right = -gradient;
      for (size_t i = 0; i < coordinates_.size(); ++i) {
        const Coordinate& c = coordinates_[i];
        const bool held =
            (z_[i] <= c.min && gradient[i] > 0) || (z_[i] >= c.max && gradient[i] < 0);
        if (!free_[i] || held || !(hessian(i, i) > 0)) {
          damped.row(i).setZero();
          damped.col(i).setZero();
          damped(i, i) = 1;
          right[i] = 0;
        } else {
          damped(i, i) *= 1 + damping;
        }
      }
      const Vector step = solve_symmetric(damped, right);
      Vector z = z_ + step;
      for (size_t i = 0; i < coordinates_.size(); ++i)
        z[i] = std::clamp(z[i], coordinates_[i].min, coordinates_[i].max);
      if (!step.allFinite() || z == z_) break;
      accepted = move_to(z);
      damping = accepted ? damping * 0.2 : std::max(damping * 10, 1e-3);
    }
    if (!accepted || before - cost_ < 1e-3 * unit()) return;
  }
}

// Steps along each coordinate, wide to narrow; true where it found a clearly better place.
bool WideFitter::pattern_search() {
  const double before = cost_;
  for (const double width : {16.0, 4.0, 1.0}) {
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      if (!free_[i] || coordinates_[i].spread) continue;
      for (const double sign : {1.0, -1.0}) {
        for (int repeat = 0; repeat < 8; ++repeat) {
          const Vector z = moved(i, sign * width * coordinates_[i].step);
          if (z == z_ || !move_to(z)) break;
        }
      }
    }
  }
  return before - cost_ > 0.5 * unit();
}

// Factors on a sigma, wide to narrow.
void WideFitter::fit_spread(size_t i) {
  for (const double factor : {3.0, 1.3, 1.05, 1.01}) {
    for (const double by : {factor, 1 / factor}) {
      for (int repeat = 0; repeat < 6; ++repeat) {
        const double z = std::max(z_[i], 1e-3 * coordinates_[i].parameter->scale);
        const Vector next = moved(i, z * by - z_[i]);
        if (next == z_ || !move_to(next)) break;
      }
    }
  }
  Vector absent = z_;
  absent[i] = coordinates_[i].parameter->neutral;
  if (cost_at(absent) <= cost_ + 1e-6) {
    here_ = problem_.evaluate(at(absent), groups_, &here_);
    z_ = absent, cost_ = cost_of(here_);
  }
}

void WideFitter::descend() {
  for (int round = 0; round < 4; ++round) {
    levenberg_marquardt();
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      if (free_[i] && coordinates_[i].spread) fit_spread(i);
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
  const Coordinate& c = coordinates_[i];
  for (const double share : {0.2, 0.4, 0.6, 0.8}) {
    z_ = z0;
    z_[i] = c.min + share * (c.max - c.min);
    here_ = problem_.evaluate(at(z_), groups_);
    cost_ = cost_of(here_);
    free_[i] = 1;
    descend();
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
  const Coordinate& c = coordinates_[i];
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
    double inside = 0, outside = std::max(sigma, c.least_step);
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
  const size_t count = coordinates_.size();
  Fit fit{.log_likelihood = -0.5 * cost_, .converged = std::isfinite(cost_)};
  fit.sigma.assign(count, kInfinity);
  fit.covariance.assign(count * count, 0);
  fit.at_bound.assign(count, 0);
  if (std::isfinite(cost_)) {
    const Eigen::MatrixXd j = jacobian();
    Eigen::MatrixXd information = j.transpose() * j;
    std::vector<char> known(count);
    for (size_t i = 0; i < count; ++i) {
      known[i] = information(i, i) > 0;
      if (!known[i]) information(i, i) = 1;
    }
    const Vector scale = information.diagonal().cwiseSqrt();
    const Eigen::MatrixXd unit =
        scale.cwiseInverse().asDiagonal() * information * scale.cwiseInverse().asDiagonal();
    Eigen::MatrixXd covariance = floored_inverse(unit, 1e-12);
    covariance = scale.cwiseInverse().asDiagonal() * covariance * scale.cwiseInverse().asDiagonal();
    // A misfit larger than the noise makes estimates less certain in proportion.
    const double misfit = std::max(1.0, score_of(problem_, here_).error());
    covariance *= misfit * misfit;
    for (size_t i = 0; i < count; ++i) {
      if (!known[i]) continue;
      const double flat = free_[i] ? flat_width(i, 1 / scale[i]) : 0;
      if (flat * flat > covariance(i, i)) covariance(i, i) = flat * flat;
    }
    for (size_t a = 0; a < count; ++a) {
      for (size_t b = 0; b < count; ++b) {
        if (known[a] && known[b]) fit.covariance[a * count + b] = covariance(a, b);
      }
    }
  }
  for (size_t i = 0; i < count; ++i) {
    if (!coordinates_[i].spread || !free_[i]) continue;
    const double h = std::max(0.05 * z_[i], 1e-3 * coordinates_[i].parameter->scale);
    const double curvature =
        (cost_at(moved(i, h)) - 2 * cost_ + cost_at(moved(i, -std::min(h, z_[i])))) / (h * h);
    if (curvature > 0) fit.covariance[i * count + i] = 2 / curvature;
  }
  fit.model = at(z_);
  for (size_t i = 0; i < count; ++i) {
    const Coordinate& c = coordinates_[i];
    const double value = c.to_value(z_[i]);
    fit.value.push_back(value);
    // d(1/z) = -dz / z^2.
    const double slope = c.parameter->fit_reciprocal ? -value * value : 1;
    for (size_t b = 0; b < count; ++b) {
      if (std::isfinite(slope)) {
        fit.covariance[i * count + b] *= slope;
        fit.covariance[b * count + i] *= slope;
      }
    }
    const bool at_min =
        z_[i] <= c.min && !c.parameter->fit_reciprocal && c.parameter->min != c.parameter->neutral;
    fit.at_bound[i] = at_min || z_[i] >= c.max;
  }
  for (size_t i = 0; i < count; ++i) {
    const double variance = fit.covariance[i * count + i];
    if (!free_[i])
      fit.sigma[i] = 0;
    else if (variance > 0 && std::isfinite(fit.value[i]))
      fit.sigma[i] = std::sqrt(variance);
  }
  fit.log_likelihood = -0.5 * cost_;
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
  return WideFitter(problem, start, unknowns, groups).run();
}

}  // namespace seam::measurement
