// Fits of ranges. The detector's answer is a staircase in every parameter: its trend leads near the
// right place, where it has many treads, and only there do all steps agree. So the prediction is
// smoothed over displacements of the image: widely at first, by a whole colour pixel, which shows
// the trend, then less and less. From each width to the next, places are drawn from what the wider
// one leaves open, and the best is kept.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/kinds/ranges/ranges.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kWide_px =
    1;  // Half a colour pixel to either side of its middle: no steps are left.
constexpr size_t kMostDraws = 16;

// One unknown in the coordinate in which it is fitted: limits without end by their reciprocal.
struct Coordinate {
  Unknown unknown;
  const effects::Parameter* parameter = nullptr;
  double min = 0, max = 0, scale = 1;
  bool spread =
      false;  // Of a noise alone: sought on the likelihood, which has no slope where it begins.

  Coordinate(const Model& model, const Unknown& u)
      : unknown(u), parameter(&model.find(u.effect)->definition->parameters[u.parameter]) {
    const effects::Parameter& p = *parameter;
    min = p.fit_reciprocal ? 0 : p.min;
    max = p.fit_reciprocal ? 1 / std::max(p.min, 1e-300) : p.max;
    scale = p.fit_reciprocal ? 1 / p.scale : p.scale;
    spread = model.find(u.effect)->definition->spread_only;
  }
  double to_value(double z) const {
    return parameter->fit_reciprocal ? (z > 0 ? 1 / z : kInfinity) : z;
  }
  double of(const Model& model) const {
    const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
    return std::clamp(parameter->fit_reciprocal ? 1 / value : value, min, max);
  }
  void set(Model& model, double z) const {
    model.set_value(unknown.effect, unknown.parameter, to_value(z));
  }
};

double first_step(const Coordinate& c) {
  return 0.1 * c.scale;
}

// Derivative of the residuals by a coordinate, over a step that they notice: about their own sigma.
// `h` is the step to begin with, and gets the one taken.
std::vector<double> slope(const RangesProblem& problem, const Model& model, const Coordinate& c,
                          const Groups& groups, double dither_px, double& h) {
  constexpr double kLeast = 0.4, kMost = 2.5;
  const double z = c.of(model);
  std::vector<double> column;
  for (int attempt = 0; attempt < 5; ++attempt) {
    const double up = std::min(z + h, c.max), down = std::max(z - h, c.min);
    if (!(up > down)) break;
    Model moved = model;
    c.set(moved, up);
    const Evaluation above = problem.evaluate_smoothed(moved, groups, dither_px);
    c.set(moved, down);
    const Evaluation below = problem.evaluate_smoothed(moved, groups, dither_px);
    if (!above.valid || !below.valid) {
      h *= 0.2;
      continue;
    }
    column.assign(above.residual.size(), 0);
    double square = 0, count = 0;
    for (size_t i = 0; i < column.size(); ++i) {
      if (!above.used[i]) continue;
      const double rise = above.residual[i] - below.residual[i];
      column[i] = rise / (up - down);
      const double d = rise / (0.5 * (above.sigma[i] + below.sigma[i]));
      square += d * d, count += 1;
    }
    const double rms = std::sqrt(square / std::max(1.0, count));
    const double most = 0.5 * (std::isfinite(c.max) ? c.max - c.min : 100 * c.scale);
    if (rms < 1e-3 && h < most) {  // Whatever it does lies far off, if anywhere.
      h = most;
      continue;
    }
    if ((rms > kLeast && rms < kMost) || (rms < kLeast && h >= most)) break;
    h = std::min(h * std::clamp(1 / std::max(rms, 1e-9), 0.05, 20.0), most);
  }
  return column;
}

// What brings each coordinate's curvature to 1; 0 for one that changes nothing.
VectorXd unit_scale(const MatrixXd& normal) {
  VectorXd scale(normal.rows());
  for (Eigen::Index i = 0; i < normal.rows(); ++i)
    scale[i] = normal(i, i) > 0 ? 1 / std::sqrt(normal(i, i)) : 0;
  return scale;
}

class RangesFit {
 public:
  RangesFit(const RangesProblem& problem, const Model& start, const std::vector<Unknown>& unknowns,
            const Groups& groups)
      : problem_(problem), groups_(groups), model_(start) {
    for (const Unknown& unknown : unknowns) {
      coordinates_.emplace_back(start, unknown);
      steps_.push_back(first_step(coordinates_.back()));
    }
  }

  Fit run() {
    const bool mean = std::any_of(coordinates_.begin(), coordinates_.end(),
                                  [](const Coordinate& c) { return !c.spread; });
    if (mean) {
      look(kWide_px);
      descend(kWide_px, 2);  // Leaves its slopes for the draw.
      if (here_.valid) draw();
      descend(kPlaceAccuracy_px, 2);
    }
    look(0);
    if (here_.valid) {
      search_spreads();
      if (mean) search_nearby();
    }
    return result();
  }

 private:
  double likelihood(const Evaluation& evaluation) const {
    return evaluation.valid ? score_of(problem_, evaluation).log_likelihood : -kInfinity;
  }
  void look(double dither_px) {
    here_ = problem_.evaluate_smoothed(model_, groups_, dither_px);
    likelihood_ = likelihood(here_);
  }
  bool move_to(const Model& model, double dither_px) {
    Evaluation there = problem_.evaluate_smoothed(model, groups_, dither_px);
    const double value = likelihood(there);
    if (!(value > likelihood_)) return false;
    model_ = model, here_ = std::move(there), likelihood_ = value;
    return true;
  }
  void take_slopes(double dither_px) {
    slopes_.clear();
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      const Coordinate& c = coordinates_[i];
      slopes_.push_back(c.spread ? std::vector<double>{}
                                 : slope(problem_, model_, c, groups_, dither_px, steps_[i]));
    }
  }
  void normal_equations(MatrixXd& normal, VectorXd& right) const;
  void descend(double dither_px, int most) {
    for (int i = 0; i < most && here_.valid; ++i) {
      if (!step(dither_px)) return;
    }
  }
  bool step(double dither_px);
  void draw();
  void search_spreads();
  void search_nearby();
  double sigma_of_spread(const Coordinate& c) const;
  Fit result() const;

  const RangesProblem& problem_;
  const Groups& groups_;
  Model model_;
  std::vector<Coordinate> coordinates_;
  std::vector<double> steps_;                // Of differences, by coordinate.
  std::vector<std::vector<double>> slopes_;  // Of residuals, by coordinate.
  Evaluation here_;
  double likelihood_ = 0;
};

void RangesFit::normal_equations(MatrixXd& normal, VectorXd& right) const {
  const auto count = static_cast<Eigen::Index>(coordinates_.size());
  normal = MatrixXd::Zero(count, count);
  right = VectorXd::Zero(count);
  for (size_t i = 0; i < here_.used.size(); ++i) {
    if (!here_.used[i]) continue;
    VectorXd row = VectorXd::Zero(count);
    for (size_t k = 0; k < slopes_.size(); ++k)
      row[static_cast<Eigen::Index>(k)] = slopes_[k].empty() ? 0 : slopes_[k][i] / here_.sigma[i];
    normal += row * row.transpose();
    right -= here_.whitened[i] * row;
  }
}

// One damped step of Gauss and Newton; false when it gains nothing worth another.
bool RangesFit::step(double dither_px) {
  take_slopes(dither_px);
  MatrixXd normal;
  VectorXd right;
  normal_equations(normal, right);
  const auto count = static_cast<Eigen::Index>(coordinates_.size());
  const VectorXd scale = unit_scale(normal);
  const MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
  const double before = likelihood_;
  for (const double damping : {1e-3, 0.3, 3.0, 30.0}) {
    MatrixXd damped = unit;
    for (Eigen::Index i = 0; i < count; ++i) damped(i, i) += scale[i] > 0 ? damping : 1;
    const VectorXd scaled_right = scale.cwiseProduct(right);
    const VectorXd by = scale.cwiseProduct(solve_symmetric(damped, scaled_right));
    Model candidate = model_;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Coordinate& c = coordinates_[static_cast<size_t>(i)];
      c.set(candidate, std::clamp(c.of(model_) + by[i], c.min, c.max));
    }
    if (move_to(candidate, dither_px))
      return likelihood_ - before > std::max(1.0, 0.02 * std::abs(likelihood_));
  }
  return false;
}

// To the narrow width: to the best of some places drawn from what the wide one leaves open, a few
// of them from far out, since slopes tell only what is near.
void RangesFit::draw() {
  MatrixXd normal;
  VectorXd right;
  normal_equations(normal, right);
  const Eigen::Index count = normal.rows();
  const VectorXd scale = unit_scale(normal);
  MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
  for (Eigen::Index i = 0; i < count; ++i) unit(i, i) += scale[i] > 0 ? 1e-3 : 1;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> axes(unit);
  const Model centre = model_;
  const RandomStream stream = RandomStream{.seed = 0x5EA3}.child("ranges_fit");
  look(kPlaceAccuracy_px);
  const size_t draws = std::min(kMostDraws, 4 + 4 * coordinates_.size());
  for (size_t k = 0; k < draws; ++k) {
    VectorXd away(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      away[i] = (k % 2 == 0 ? 1 : 3) *
                seam::normal(stream, k * static_cast<size_t>(count) + static_cast<size_t>(i)) /
                std::sqrt(std::max(axes.eigenvalues()[i], 1e-3));
    }
    const VectorXd by = scale.cwiseProduct(axes.eigenvectors() * away);
    Model candidate = centre;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Coordinate& c = coordinates_[static_cast<size_t>(i)];
      if (!c.spread) c.set(candidate, std::clamp(c.of(centre) + by[i], c.min, c.max));
    }
    move_to(candidate, kPlaceAccuracy_px);
  }
}

// Factors on each noise, wide to narrow.
void RangesFit::search_spreads() {
  for (const double factor : {4.0, 1.6, 1.2, 1.06}) {
    for (const Coordinate& c : coordinates_) {
      if (!c.spread) continue;
      for (const double by : {factor, 1 / factor}) {
        bool moved = false;
        for (int repeat = 0; repeat < 3; ++repeat) {
          Model candidate = model_;
          c.set(candidate, std::clamp(by * std::max(c.of(model_), 1e-3 * c.scale), c.min, c.max));
          if (!move_to(candidate, 0)) break;
          moved = true;
        }
        if (moved) break;
      }
    }
  }
}

// From the curvature of the likelihood.
double RangesFit::sigma_of_spread(const Coordinate& c) const {
  const double z = c.of(model_), h = std::max(0.2 * z, 1e-3 * c.scale);
  const auto at = [&](double value) {
    Model moved = model_;
    c.set(moved, std::clamp(value, c.min, c.max));
    return likelihood(problem_.evaluate(moved, groups_));
  };
  const double curvature = (2 * likelihood_ - at(z + h) - at(z - h)) / (h * h);
  return curvature > 0 ? 1 / std::sqrt(curvature) : kInfinity;
}

// Each coordinate a little to either side, wide to narrow.
void RangesFit::search_nearby() {
  MatrixXd normal;
  VectorXd right;
  normal_equations(normal, right);
  for (const double width : {1.0, 0.3}) {
    for (size_t i = 0; i < coordinates_.size(); ++i) {
      const Coordinate& c = coordinates_[i];
      const double along = normal(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      if (!(along > 0)) continue;
      for (const double sign : {1.0, -1.0}) {
        Model candidate = model_;
        c.set(candidate, std::clamp(c.of(model_) + sign * width / std::sqrt(along), c.min, c.max));
        if (move_to(candidate, 0)) break;
      }
    }
  }
}

Fit RangesFit::result() const {
  const size_t count = coordinates_.size();
  Fit fit{.model = model_, .log_likelihood = likelihood_, .converged = here_.valid};
  fit.sigma.assign(count, kInfinity);
  fit.covariance.assign(count * count, 0);
  fit.at_bound.assign(count, 0);
  for (size_t i = 0; i < count; ++i) {
    const Coordinate& c = coordinates_[i];
    const double z = c.of(model_);
    fit.value.push_back(c.to_value(z));
    const double neutral = c.parameter->fit_reciprocal ? 0 : c.parameter->neutral;
    fit.at_bound[i] = (z <= c.min && c.min != neutral) || (z >= c.max && c.max != neutral);
  }
  if (!here_.valid || count == 0) return fit;
  MatrixXd normal;
  VectorXd right;
  normal_equations(normal, right);
  for (Eigen::Index i = 0; i < normal.rows(); ++i) {
    if (!(normal(i, i) > 0)) normal(i, i) = 0;
  }
  const VectorXd scale = unit_scale(normal);
  MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
  for (Eigen::Index i = 0; i < unit.rows(); ++i) unit(i, i) += scale[i] > 0 ? 0 : 1;
  // A misfit larger than the noise makes estimates less certain in proportion.
  const double misfit = std::max(1.0, score_of(problem_, here_).error());
  const MatrixXd covariance =
      misfit * misfit * (scale.asDiagonal() * floored_inverse(unit, 1e-12) * scale.asDiagonal());
  // d(1/z) = -dz / z^2.
  const auto rate = [&](size_t i) {
    return coordinates_[i].parameter->fit_reciprocal ? -fit.value[i] * fit.value[i] : 1.0;
  };
  for (size_t i = 0; i < count; ++i) {
    if (!(scale[static_cast<Eigen::Index>(i)] > 0) || !std::isfinite(rate(i))) continue;
    for (size_t k = 0; k < count; ++k) {
      if (!std::isfinite(rate(k))) continue;
      fit.covariance[i * count + k] =
          rate(i) * rate(k) *
          covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
    fit.sigma[i] = std::sqrt(fit.covariance[i * count + i]);
  }
  for (size_t i = 0; i < count; ++i) {
    if (!coordinates_[i].spread) continue;
    fit.sigma[i] = std::abs(rate(i)) * sigma_of_spread(coordinates_[i]);
    if (std::isfinite(fit.sigma[i])) fit.covariance[i * count + i] = fit.sigma[i] * fit.sigma[i];
  }
  return fit;
}

}  // namespace

std::vector<std::vector<double>> RangesProblem::jacobian(const Model& model,
                                                         const std::vector<Unknown>& unknowns,
                                                         const Groups& groups,
                                                         const Evaluation& here) const {
  std::vector<std::vector<double>> columns;
  for (const Unknown& unknown : unknowns) {
    const Coordinate c(model, unknown);
    double h = first_step(c);
    std::vector<double> column = slope(*this, model, c, groups, kPlaceAccuracy_px, h);
    column.resize(facts_.scalars(), 0);
    const double value = c.to_value(c.of(model));
    const double rate =
        c.parameter->fit_reciprocal && std::isfinite(value) ? -1 / (value * value) : 1;
    for (size_t i = 0; i < column.size(); ++i)
      column[i] = here.used[i] ? rate * column[i] / here.sigma[i] : 0;
    columns.push_back(std::move(column));
  }
  return columns;
}

Fit RangesProblem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                       const Groups& groups) const {
  return RangesFit(*this, start, unknowns, groups).run();
}

}  // namespace seam::measurement
