// Fits of outcomes: few steps of Gauss and Newton, since each look costs whole runs. Slopes are
// differences over steps that the set notices, by runs with the same seeds.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/outcomes/outcomes.h"
#include "measurement/numerics/damped_step.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostSteps = 4;
constexpr int kMostRounds = 3;
constexpr double kFits = 1.3;  // Root mean square of whitened residuals: nothing is left to find.
constexpr double kFirstStep = 0.1;   // Of a coordinate's scale.
constexpr double kLargestStep = 10;  // What lies farther is no robot that anybody built.
constexpr double kWorth = 0.1;       // Of log-likelihood: below it, the runs' own scatter decides.

double size_of(const std::vector<double>& whitened) {
  double square = 0, count = 0;
  for (const double value : whitened) square += value * value, count += value != 0;
  return std::sqrt(square / std::max(1.0, count));
}

// Steps are rounded to powers of two: sets that were measured by one protocol share their runs.
double on_grid(double h, double scale) {
  const double unit = kFirstStep * scale;
  return unit * std::exp2(std::round(std::log2(h / unit)));
}

class OutcomesFit {
 public:
  OutcomesFit(const OutcomesProblem& problem, const Model& start,
              const std::vector<Unknown>& unknowns, const Groups& groups)
      : problem_(problem),
        groups_(groups),
        space_(start, unknowns),
        box_(space_.box()),
        model_(start) {
    for (size_t i = 0; i < space_.size(); ++i) {
      steps_.push_back(kFirstStep * space_[i].scale);
      const auto stated = problem.bounds(space_[i].unknown.effect, space_[i].parameter->name);
      if (!stated || space_[i].parameter->fit_reciprocal) continue;
      box_.low[static_cast<Eigen::Index>(i)] = stated->low;
      box_.high[static_cast<Eigen::Index>(i)] = stated->high;
    }
  }

  Fit run() {
    here_ = problem_.evaluate(model_, groups_);
    height_ = height_of(here_);
    DescentEnd end;
    // Slopes over wide steps lead near; where a misfit stays, those over narrower ones lead on.
    for (int round = 0; round < kMostRounds && here_.valid && space_.size() > 0; ++round) {
      const double before = height_;
      slopes_.resize(0, 0);
      end = descend(descent(), rule(), kMostSteps);
      if (!(before - height_ > kWorth) || size_of(here_.whitened) < kFits) break;
    }
    return result(end);
  }

 private:
  static DampingRule rule() {
    return {.start = 1e-3, .shrink = 0, .least = 1e-3, .firm = 0.3, .attempts = 3};
  }
  double height_of(const Evaluation& evaluation) const {
    return evaluation.valid ? -log_likelihood_of(problem_, evaluation)
                            : std::numeric_limits<double>::infinity();
  }
  Descent descent() {
    return {.look = [this] { return look(); },
            .move =
                [this](const VectorXd& by) {
                  const VectorXd there = box_.inside(space_.place(model_) + by);
                  Model moved = space_.at(model_, there);
                  Evaluation evaluation = problem_.evaluate(moved, groups_);
                  const double height = height_of(evaluation);
                  if (!(height < height_)) return false;
                  model_ = std::move(moved), here_ = std::move(evaluation), height_ = height;
                  return true;
                },
            .height = [this] { return height_; },
            .worth = [] { return Worth{.promise = kWorth, .again = kWorth, .gain = kWorth}; }};
  }
  // Slopes are differences where the fit begins; from there on each step corrects them by what it
  // found (Broyden 1965), which costs no runs.
  Parabola look() {
    const VectorXd place = space_.place(model_);
    if (slopes_.size() == 0) {
      slopes_ = MatrixXd::Zero(static_cast<Eigen::Index>(here_.residual.size()),
                               static_cast<Eigen::Index>(space_.size()));
      for (size_t i = 0; i < space_.size(); ++i) {
        const auto slope = problem_.slope(model_, space_[i], groups_, steps_[i]);
        for (size_t row = 0; row < slope.size(); ++row)
          slopes_(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(i)) = slope[row];
      }
    } else {
      correct(place);
    }
    looked_at_ = place, residuals_ = residuals();
    MatrixXd jacobian(slopes_.rows(), slopes_.cols());
    for (Eigen::Index i = 0; i < slopes_.cols(); ++i) {
      const std::vector<double> slope(slopes_.col(i).begin(), slopes_.col(i).end());
      const auto white = problem_.whitened_by(model_, groups_, slope);
      for (Eigen::Index row = 0; row < slopes_.rows(); ++row)
        jacobian(row, i) = -white[static_cast<size_t>(row)];
    }
    const Eigen::Map<const VectorXd> whitened(here_.whitened.data(), slopes_.rows());
    Parabola out = parabola_of(jacobian, whitened);
    out.held = box_.held(place, out.gradient);
    curvature_ = out.curvature;
    return out;
  }
  VectorXd residuals() const {
    return Eigen::Map<const VectorXd>(here_.residual.data(),
                                      static_cast<Eigen::Index>(here_.residual.size()));
  }
  void correct(const VectorXd& place) {
    VectorXd by = place - looked_at_;
    VectorXd scale(by.size());
    for (Eigen::Index i = 0; i < by.size(); ++i) scale[i] = space_[static_cast<size_t>(i)].scale;
    const VectorXd unit = by.cwiseQuotient(scale);
    if (!(unit.squaredNorm() > 0)) return;
    const VectorXd rise = residuals_ - residuals();  // Predictions rise as residuals fall.
    const VectorXd missed = (rise - slopes_ * by) / unit.squaredNorm();
    slopes_ += missed * unit.cwiseQuotient(scale).transpose();
  }
  Fit result(const DescentEnd& end) const {
    const VectorXd place = space_.place(model_);
    const bool settled = end.reason != DescentEnd::Reason::steps_spent;
    Fit fit = space_.fit_at(model_, place, -height_, here_.valid && settled);
    if (!here_.valid || curvature_.size() == 0) return fit;
    space_.state(covariance_of(curvature_, 1e-12), misfit_of(problem_, here_), place, fit);
    for (Eigen::Index i = 0; i < place.size(); ++i) {
      const double neutral = space_[static_cast<size_t>(i)].parameter->neutral;
      const bool at_end = place[i] <= box_.low[i] || place[i] >= box_.high[i];
      if (at_end && place[i] != neutral) fit.at_bound[static_cast<size_t>(i)] = 1;
    }
    return fit;
  }

  const OutcomesProblem& problem_;
  const Groups& groups_;
  const ParameterSpace space_;
  Box box_;
  Model model_;
  std::vector<double> steps_;  // Of differences, by coordinate.
  Evaluation here_;
  double height_ = 0;
  MatrixXd slopes_;                 // Of predictions by coordinate.
  VectorXd looked_at_, residuals_;  // Where they were looked at last, and what was left there.
  MatrixXd curvature_;
};

}  // namespace

std::vector<double> OutcomesProblem::slope(const Model& model, const Coordinate& c,
                                           const Groups& groups, double& step) const {
  // Of the errors, or of a misfit beyond them: a change that is seen and still near. What runs give
  // is a staircase where pixels decide; its trend shows over steps like those that are to be made.
  constexpr double kLeast = 0.5, kMost = 2, kShareOfMisfit = 1;
  constexpr int kAttempts = 4;
  std::vector<double> here, there;
  if (!predict(model, groups, here)) return {};
  std::vector<double> missed(here.size(), 0);
  for (size_t i = 0; i < here.size(); ++i) {
    if (groups[facts_.group_of_row[i]]) missed[i] = rows_[i].measured - here[i];
  }
  const double size = std::max(1.0, kShareOfMisfit * size_of(whitened_by(model, groups, missed)));
  const double z = c.of(model);
  const auto stated = bounds(c.unknown.effect, c.parameter->name);
  const bool narrowed = stated && !c.parameter->fit_reciprocal;
  const double low = narrowed ? stated->low : c.min, high = narrowed ? stated->high : c.max;
  const double widest = std::min(kLargestStep * c.scale, std::max(high - z, z - low));
  // Away from neutral: what an effect does is seen where there is more of it.
  const double neutral = c.parameter->fit_reciprocal ? 0 : c.parameter->neutral;
  const bool away_is_up = z >= neutral;
  std::vector<double> best;
  double best_off = std::numeric_limits<double>::infinity();
  double too_near = 0, too_far = widest;
  double h = std::min(on_grid(step, c.scale), widest);
  for (int attempt = 0; attempt < kAttempts && h > 0; ++attempt) {
    const bool up = away_is_up ? z + h <= high : z - h < low;
    const double to = std::clamp(up ? z + h : z - h, low, high);
    Model moved = model;
    c.set(moved, to);
    if (!predict(moved, groups, there)) {
      h *= 0.2;
      continue;
    }
    std::vector<double> column(here.size());
    for (size_t i = 0; i < here.size(); ++i) column[i] = there[i] - here[i];
    const double noticed = size_of(whitened_by(model, groups, column)) / size;
    const double off = noticed > 0 ? std::abs(std::log(noticed)) : 1e300;
    if (off < best_off) {
      for (double& value : column) value /= to - z;
      best = std::move(column), best_off = off, step = h;
    }
    if (noticed >= kLeast && noticed < kMost) break;
    if (noticed < kLeast && h >= widest) break;
    (noticed < kLeast ? too_near : too_far) = h;
    double next = noticed > 0 ? std::clamp(h / noticed, 0.05 * h, 10 * h) : widest;
    // Between one that is not seen and one beyond a cliff.
    if (too_near > 0 && too_far < widest) next = std::sqrt(too_near * too_far);
    next = std::min(on_grid(next, c.scale), widest);
    if (next == h) break;
    h = next;
  }
  return best;
}

std::vector<std::vector<double>> OutcomesProblem::jacobian(const Model& model,
                                                           const std::vector<Unknown>& unknowns,
                                                           const Groups& groups,
                                                           const Evaluation&) const {
  std::vector<std::vector<double>> columns;
  for (const Unknown& unknown : unknowns) {
    const Coordinate c(model, unknown);
    double step = kFirstStep * c.scale;
    std::vector<double> column = slope(model, c, groups, step);
    column.resize(rows_.size(), 0);
    const double by_coordinate = c.slope(c.of(model));
    const double rate = std::isfinite(by_coordinate) ? -1 / by_coordinate : -1;
    for (double& value : column) value *= rate;
    columns.push_back(whitened_by(model, groups, column));
  }
  return columns;
}

Fit OutcomesProblem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                         const Groups& groups) const {
  return OutcomesFit(*this, start, unknowns, groups).run();
}

}  // namespace seam::measurement
