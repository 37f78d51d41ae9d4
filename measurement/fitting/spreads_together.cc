#include "measurement/fitting/spreads_together.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "measurement/numerics/box.h"
#include "measurement/numerics/curvature.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/maximise.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kLeast = 1e-4;         // Of its scale: less is nothing.
constexpr double kWorthAnother = 0.02;  // What a further descent must have gained.

// Fisher's scoring: where residuals are innovations v with variances s^2 of their own,
//
//   I_ab = sum dv_a dv_b / s^2 + 2 dlog s_a dlog s_b
//
// tells the curvature from first differences, one look a parameter, where second differences take
// n (n + 1). The gradient is that of the likelihood itself.
class Scoring {
 public:
  Scoring(const Problem& problem, const ParameterSpace& space, const Model& model,
          const Groups& groups, const SpreadsTogether& begin)
      : problem_(problem),
        space_(space),
        model_(model),
        groups_(groups),
        which_(begin.which),
        all_(begin.place),
        z_(static_cast<Index>(which_.size())),
        box_{z_, z_} {
    for (size_t k = 0; k < which_.size(); ++k) {
      const Coordinate& c = space[which_[k]];
      const auto i = static_cast<Index>(k);
      box_.low[i] = std::log(std::max(c.min, kLeast * c.scale)), box_.high[i] = std::log(c.max);
      z_[i] = std::clamp(std::log(all_[static_cast<Index>(which_[k])]), box_.low[i], box_.high[i]);
    }
  }

  // False where variances are not the residuals' own, or the way does not lead down.
  bool run(const Evaluation* warm) {
    constexpr int kMost = 40;
    constexpr double kNothing = 1e-4;
    warm_ = warm;
    here_ = at(z_);
    if (!here_.valid || !here_.mean_square.empty() || here_.whitened.size() > here_.used.size())
      return false;
    height_ = -log_likelihood_of(problem_, here_);
    const DescentEnd end = descend(
        {.look = [&] { return look(); },
         .move = [&](const VectorXd& by) { return move(by); },
         .height = [&] { return height_; },
         .worth = [] { return Worth{.promise = kNothing, .again = kNothing, .gain = kNothing}; }},
        {.start = 1e-6, .attempts = 12}, kMost);
    using Reason = DescentEnd::Reason;
    return own_variances_ &&
           (end.reason == Reason::nothing_promised || end.reason == Reason::nothing_gained);
  }

  void state(SpreadsTogether& out) const {
    const MatrixXd covariance = covariance_of(information_, 1e-10).matrix;
    const VectorXd value = z_.array().exp();
    for (Index a = 0; a < z_.size(); ++a) {
      out.place[static_cast<Index>(which_[static_cast<size_t>(a)])] = value[a];
      for (Index b = 0; b < z_.size(); ++b)
        out.covariance.push_back(value[a] * value[b] * covariance(a, b));
    }
    out.log_likelihood = -height_;
  }

 private:
  Evaluation at(const VectorXd& z) const {
    VectorXd place = all_;
    for (size_t k = 0; k < which_.size(); ++k)
      place[static_cast<Index>(which_[k])] = std::exp(z[static_cast<Index>(k)]);
    return problem_.evaluate(space_.at(model_, place), groups_, warm_);
  }

  Parabola look() {
    constexpr double kStep = 1e-4, kOwn = 0.05, kRounding = 1e-6;
    constexpr Index kWorthThreads = 10'000;
    const auto n = static_cast<Index>(here_.used.size());
    // By scalar: dv / s, and dlog s, by parameter.
    MatrixXd moved = MatrixXd::Zero(n, z_.size()), widened = moved;
    // By how much more log det S changes than the scalars' own variances say.
    VectorXd slope = VectorXd::Constant(z_.size(), std::numeric_limits<double>::infinity()),
             beyond = slope;
    const auto look_along = [&](size_t k) {
      const auto i = static_cast<Index>(k);
      VectorXd there_z = z_;
      const double h = z_[i] + kStep > box_.high[i] ? -kStep : kStep;
      there_z[i] += h;
      const Evaluation there = at(there_z);
      if (!there.valid) return;
      double own = 0, stated = there.shared_log_det - here_.shared_log_det;
      for (Index row = 0; row < n; ++row) {
        const auto r = static_cast<size_t>(row);
        // What a run begins with is fitted by it, whatever its variance.
        if (!here_.used[r] || (here_.whitened[r] == 0 && there.whitened[r] == 0)) continue;
        const double wider = std::log(there.sigma[r] / here_.sigma[r]) / h;
        moved(row, i) = (there.whitened[r] - here_.whitened[r]) / h + here_.whitened[r] * wider;
        widened(row, i) = wider;
        own += 2 * wider;
      }
      for (size_t g = 0; g < there.log_det.size(); ++g)
        stated += there.log_det[g] - here_.log_det[g];
      slope[i] = (-log_likelihood_of(problem_, there) - height_) / h;
      beyond[i] = std::abs(own - stated / h) - kOwn * 2 * widened.col(i).lpNorm<1>();
    };
    parallel_for(which_.size(), look_along, n > kWorthThreads);
    own_variances_ = own_variances_ && slope.allFinite() && beyond.maxCoeff() <= kRounding;
    information_ = moved.transpose() * moved + 2 * (widened.transpose() * widened);
    // Where variances are not their own there is nothing to go by.
    if (!own_variances_) information_.setZero();
    return {information_, slope, box_.held(z_, slope), {}};
  }

  bool move(const VectorXd& by) {
    constexpr double kMost = 2;  // A factor of seven: far off, a parabola misleads.
    const VectorXd trial = box_.inside(z_ + by.cwiseMax(-kMost).cwiseMin(kMost));
    Evaluation there = at(trial);
    const double height =
        there.valid ? -log_likelihood_of(problem_, there) : std::numeric_limits<double>::infinity();
    if (!(height < height_)) return false;
    z_ = trial, height_ = height, here_ = std::move(there);
    return true;
  }

  const Problem& problem_;
  const ParameterSpace& space_;
  const Model& model_;
  const Groups& groups_;
  const std::vector<size_t>& which_;
  const VectorXd& all_;  // Where all coordinates stand; these are moved.
  VectorXd z_;           // Logarithms of those that are fitted.
  Box box_;
  const Evaluation* warm_ = nullptr;
  Evaluation here_;
  double height_ = 0;  // Minus the log-likelihood.
  MatrixXd information_;
  bool own_variances_ = true;
};

// Half of the standard deviation that each has beside the others, where all are known and small:
// across a narrow valley far less than that of the parameter itself.
void take_steps(const SpreadsTogether& before, std::vector<SearchParameter>& parameters) {
  const auto n = static_cast<Index>(parameters.size());
  const MatrixXd covariance = Eigen::Map<const MatrixXd>(before.covariance.data(), n, n);
  const VectorXd information = inverse_of(covariance).diagonal();
  std::vector<double> steps;
  for (Index k = 0; k < n; ++k) {
    const double value = before.place[static_cast<Index>(before.which[k])];
    steps.push_back(0.5 / (std::sqrt(information[k]) * value));
    if (!(steps.back() > 0 && steps.back() < parameters[k].step)) return;
  }
  for (size_t k = 0; k < steps.size(); ++k)
    parameters[k].step = steps[k], parameters[k].step_fits = true;
}

}  // namespace

bool SpreadsTogether::has(size_t coordinate) const {
  return std::find(which.begin(), which.end(), coordinate) != which.end();
}

bool SpreadsTogether::holds_at(double likelihood) const {
  return !which.empty() && std::abs(likelihood - log_likelihood) < kWorthAnother;
}

void SpreadsTogether::state(Fit& fit) const {
  for (size_t a = 0; a < which.size(); ++a) {
    for (size_t b = 0; b < which.size(); ++b)
      fit.covariance[which[a] * fit.value.size() + which[b]] = covariance[a * which.size() + b];
    const double variance = covariance[a * which.size() + a];
    fit.sigma[which[a]] =
        variance > 0 ? std::sqrt(variance) : std::numeric_limits<double>::infinity();
  }
}

SpreadsTogether fit_spreads_together(const Problem& problem, const ParameterSpace& space,
                                     const Model& model, const Groups& groups,
                                     const Evaluation* warm, const SpreadsTogether* before) {
  constexpr double kNothing = 1e-3;  // Of its scale.
  SpreadsTogether out{.place = space.place(model)};
  std::map<std::string, std::vector<size_t>> by_effect;
  for (size_t i = 0; i < space.size(); ++i) {
    const double z = out.place[static_cast<Index>(i)];
    if (space[i].spread && z > kNothing * space[i].scale && !space[i].parameter->fit_reciprocal)
      by_effect[space[i].unknown.effect].push_back(i);
  }
  for (const auto& [effect, places] : by_effect) {
    if (places.size() > 1) out.which.insert(out.which.end(), places.begin(), places.end());
  }
  if (out.which.empty()) return out;
  if (Scoring scoring(problem, space, model, groups, out); scoring.run(warm)) {
    scoring.state(out);
    return out;
  }
  std::vector<SearchParameter> parameters;
  for (const size_t i : out.which) {
    parameters.push_back({.start = out.place[static_cast<Index>(i)],
                          .min = std::max(space[i].min, kLeast * space[i].scale),
                          .max = space[i].max,
                          .step = 0.1,
                          .logarithmic = true});
  }
  if (before != nullptr && before->which == out.which) take_steps(*before, parameters);
  const auto log_likelihood = [&](const std::vector<double>& values) {
    VectorXd place = out.place;
    for (size_t k = 0; k < values.size(); ++k) place[static_cast<Index>(out.which[k])] = values[k];
    const Evaluation there = problem.evaluate(space.at(model, place), groups, warm);
    return there.valid ? log_likelihood_of(problem, there)
                       : -std::numeric_limits<double>::infinity();
  };
  // Far from the end of a valley its direction is told badly: it is looked at anew from where the
  // last descent ended.
  constexpr int kDescents = 6;
  Maximum found = maximise(log_likelihood, parameters);
  for (int descent = 1; descent < kDescents && found.gained > kWorthAnother; ++descent) {
    for (size_t k = 0; k < parameters.size(); ++k)
      parameters[k].start = found.value[k], parameters[k].step_fits = false;
    found = maximise(log_likelihood, parameters);
  }
  for (size_t k = 0; k < out.which.size(); ++k)
    out.place[static_cast<Index>(out.which[k])] = found.value[k];
  out.covariance = found.covariance;
  out.log_likelihood = found.log_likelihood;
  return out;
}

}  // namespace seam::measurement
