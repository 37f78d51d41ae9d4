// Fits of ranges. The detector's answer is a staircase in every parameter: its trend leads near the
// right place, where it has many treads, and only there do all steps agree. So the prediction is
// smoothed over displacements of the image: widely at first, by a whole colour pixel, which shows
// the trend, then less and less. From each width to the next, places are drawn from what the wider
// one leaves open, and the best is kept.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/ranges/ranges.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kWide_px =
    1;  // Half a colour pixel to either side of its middle: no steps are left.
constexpr size_t kMostDraws = 16;

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

class RangesFit {
 public:
  RangesFit(const RangesProblem& problem, const Model& start, const std::vector<Unknown>& unknowns,
            const Groups& groups)
      : problem_(problem), groups_(groups), space_(start, unknowns), model_(start) {
    for (const Coordinate& c : space_) steps_.push_back(first_step(c));
  }

  Fit run() {
    const bool mean = space_.any_of_mean();
    if (mean) {
      look(kWide_px);
      go_down(kWide_px, 2);  // Leaves its slopes for the draw.
      if (here_.valid) draw();
      go_down(kPlaceAccuracy_px, 2);
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
    return evaluation.valid ? log_likelihood_of(problem_, evaluation) : -kInfinity;
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
  void take_slopes(double dither_px);
  Parabola parabola() const;
  void go_down(double dither_px, int most);
  void draw();
  void search_spreads();
  void search_nearby();
  Fit result() const;

  const RangesProblem& problem_;
  const Groups& groups_;
  const ParameterSpace space_;
  Model model_;
  std::vector<double> steps_;  // Of differences, by coordinate.
  MatrixXd slopes_;            // Of residuals, by coordinate.
  Evaluation here_;
  double likelihood_ = 0;
};

void RangesFit::take_slopes(double dither_px) {
  slopes_ = MatrixXd::Zero(static_cast<Eigen::Index>(here_.residual.size()),
                           static_cast<Eigen::Index>(space_.size()));
  for (size_t i = 0; i < space_.size(); ++i) {
    if (space_[i].spread) continue;
    const auto column = slope(problem_, model_, space_[i], groups_, dither_px, steps_[i]);
    for (size_t k = 0; k < column.size(); ++k)
      slopes_(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) = column[k];
  }
}

// By the slopes that were taken last, and the residuals where the fit stands.
Parabola RangesFit::parabola() const {
  MatrixXd jacobian = slopes_;
  VectorXd residuals = VectorXd::Zero(jacobian.rows());
  for (Eigen::Index k = 0; k < jacobian.rows(); ++k) {
    const auto i = static_cast<size_t>(k);
    jacobian.row(k) *= here_.used[i] ? 1 / here_.sigma[i] : 0;
    residuals[k] = here_.used[i] ? here_.whitened[i] : 0;
  }
  Parabola out = parabola_of(jacobian, residuals);
  out.held = space_.box().held(space_.place(model_), out.gradient);
  return out;
}

// A few steps, each from slopes of its own: what they gain beyond is the staircase's.
void RangesFit::go_down(double dither_px, int most) {
  if (!here_.valid) return;
  descend({.look =
               [&] {
                 take_slopes(dither_px);
                 return parabola();
               },
           .move = [&](const VectorXd& by) { return move_to(space_.moved(model_, by), dither_px); },
           .height = [&] { return -likelihood_; },
           .worth = [&] { return Worth{.gain = std::max(1.0, 0.02 * std::abs(likelihood_))}; }},
          {.start = 1e-3, .shrink = 0, .least = 1e-3, .firm = 0.3, .attempts = 4}, most);
}

// To the narrow width: to the best of some places drawn from what the wide one leaves open, a few
// of them from far out, since slopes tell only what is near.
void RangesFit::draw() {
  const MatrixXd information = parabola().curvature;
  const Eigen::Index count = information.rows();
  // What brings each coordinate's curvature to 1; 0 for one that changes nothing.
  VectorXd scale(count);
  for (Eigen::Index i = 0; i < count; ++i)
    scale[i] = information(i, i) > 0 ? 1 / std::sqrt(information(i, i)) : 0;
  MatrixXd unit = scale.asDiagonal() * information * scale.asDiagonal();
  for (Eigen::Index i = 0; i < count; ++i) unit(i, i) += scale[i] > 0 ? 1e-3 : 1;
  const SymmetricEigen axes = symmetric_eigen(unit);
  const Model centre = model_;
  const RandomStream stream = RandomStream{.seed = 0x5EA3}.child("ranges_fit");
  look(kPlaceAccuracy_px);
  const size_t draws = std::min(kMostDraws, 4 + 4 * space_.size());
  for (size_t k = 0; k < draws; ++k) {
    VectorXd away(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      away[i] = (k % 2 == 0 ? 1 : 3) *
                seam::normal(stream, k * static_cast<size_t>(count) + static_cast<size_t>(i)) /
                std::sqrt(std::max(axes.values[i], 1e-3));
    }
    const VectorXd by = scale.cwiseProduct(axes.vectors * away);
    Model candidate = centre;
    for (size_t i = 0; i < space_.size(); ++i) {
      const double z = space_[i].of(centre) + by[static_cast<Eigen::Index>(i)];
      if (!space_[i].spread) candidate = space_.with(candidate, i, z);
    }
    move_to(candidate, kPlaceAccuracy_px);
  }
}

// Factors on each noise, wide to narrow.
void RangesFit::search_spreads() {
  for (const double factor : {4.0, 1.6, 1.2, 1.06}) {
    for (size_t i = 0; i < space_.size(); ++i) {
      const Coordinate& c = space_[i];
      if (!c.spread) continue;
      for (const double by : {factor, 1 / factor}) {
        bool moved = false;
        for (int repeat = 0; repeat < 3; ++repeat) {
          const double from = std::max(c.of(model_), 1e-3 * c.scale);
          if (!move_to(space_.with(model_, i, by * from), 0)) break;
          moved = true;
        }
        if (moved) break;
      }
    }
  }
}

// Each coordinate a little to either side, wide to narrow.
void RangesFit::search_nearby() {
  const VectorXd information = parabola().curvature.diagonal();
  for (const double width : {1.0, 0.3}) {
    for (size_t i = 0; i < space_.size(); ++i) {
      const double along = information[static_cast<Eigen::Index>(i)];
      if (!(along > 0)) continue;
      for (const double sign : {1.0, -1.0}) {
        const double z = space_[i].of(model_) + sign * width / std::sqrt(along);
        if (move_to(space_.with(model_, i, z), 0)) break;
      }
    }
  }
}

Fit RangesFit::result() const {
  const VectorXd place = space_.place(model_);
  Fit fit = space_.fit_at(model_, place, likelihood_, here_.valid);
  if (!here_.valid || space_.size() == 0) return fit;
  if (slopes_.size() > 0)
    space_.state(covariance_of(parabola().curvature, 1e-12), misfit_of(problem_, here_), place,
                 fit);
  for (size_t i = 0; i < space_.size(); ++i) {
    if (!space_[i].spread) continue;
    const double sigma = spread_error(problem_, space_, i, model_, groups_, nullptr, 0.2);
    space_.state(i, sigma, space_[i].of(model_), fit);
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
    const double by_coordinate = c.slope(c.of(model));
    const double rate = std::isfinite(by_coordinate) ? 1 / by_coordinate : 1;
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
