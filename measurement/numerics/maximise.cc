#include "measurement/numerics/maximise.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/numerics/box.h"
#include "measurement/numerics/curvature.h"
#include "measurement/numerics/damped_step.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Search {
 public:
  Search(const std::function<double(const std::vector<double>&)>& f,
         const std::vector<SearchParameter>& parameters)
      : f_(f),
        parameters_(parameters),
        n_(static_cast<int>(parameters.size())),
        z_(n_),
        box_{VectorXd(n_), VectorXd(n_)},
        step_(n_) {
    for (int i = 0; i < n_; ++i) {
      const SearchParameter& p = parameters[i];
      const auto inner = [&](double x) { return p.logarithmic ? std::log(std::max(x, 1e-12)) : x; };
      box_.low[i] = inner(p.min), box_.high[i] = inner(p.max);
      z_[i] = std::clamp(inner(p.start), box_.low[i], box_.high[i]);
      step_[i] = p.step;
    }
    settled_ = std::all_of(parameters.begin(), parameters.end(),
                           [](const SearchParameter& p) { return p.step_fits; });
  }

  Maximum run() {
    double here = value(z_);
    const double start = here;
    constexpr int kMostSteps = 60;
    constexpr double kNothing = 1e-4;  // A gain of log-likelihood that is not worth an evaluation.
    DampedSteps steps(
        {.start = 1e-3, .shrink = 0.125, .least = 1e-9, .grow = 6, .firm = 1e-6, .attempts = 9});
    Maximum out;
    bool misled = true;
    for (int iteration = 0; iteration < kMostSteps && n_ > 0; ++iteration) {
      // Parameters' correlations change little between most steps: they are measured at the start,
      // at the end, and where a step gained less than they promised.
      derivatives(here, misled || settled_);
      const double before = here;
      const bool accepted =
          steps.take(parabola(), {.promise = kNothing, .again = kNothing}, [&](const VectorXd& by) {
            const VectorXd trial = box_.inside(z_ + by);
            const double there = value(trial);
            if (!(there > here)) return false;
            z_ = trial, here = there;
            return true;
          }) == DampedSteps::Outcome::taken;
      const double gained = here - before;
      misled = gained < 0.7 * steps.promised();
      if (!accepted || gained < 0.01) {
        // Once more with steps that fit the curvature, unless they did already.
        if (settled_ || iteration > 20) {
          out.converged = true;
          break;
        }
        settled_ = true;
        steps.restart();
      } else if (gained > 0.1) {
        settled_ = false;
      }
    }
    if (!out.converged) derivatives(here, true);
    finish(out, here);
    out.gained = here - start;
    return out;
  }

 private:
  double value(const VectorXd& z) const {
    std::vector<double> x(n_);
    for (int i = 0; i < n_; ++i) x[i] = parameters_[i].logarithmic ? std::exp(z[i]) : z[i];
    const double v = f_(x);
    return std::isfinite(v) ? v : -std::numeric_limits<double>::max();
  }

  void derivatives(double here, bool correlations) {
    const MatrixXd before = curvature_;
    gradient_ = VectorXd::Zero(n_);
    curvature_ = MatrixXd::Zero(n_, n_);
    VectorXd plus(n_);
    for (int i = 0; i < n_; ++i) {
      // Inside the bounds, one-sided where they are near.
      double h = std::min(step_[i], 0.5 * (box_.high[i] - box_.low[i]));
      VectorXd at = z_;
      double centre = z_[i];
      if (centre + h > box_.high[i]) centre = box_.high[i] - h;
      if (centre - h < box_.low[i]) centre = box_.low[i] + h;
      at[i] = centre;
      const double middle = centre == z_[i] ? here : value(at);
      at[i] = centre + h;
      plus[i] = value(at);
      at[i] = centre - h;
      const double minus = value(at);
      const double second = (plus[i] - 2 * middle + minus) / (h * h);
      gradient_[i] = (plus[i] - minus) / (2 * h) + second * (z_[i] - centre);
      curvature_(i, i) = -second;
      used_[i] = h, shifted_[i] = centre != z_[i];
      if (-second > 0) {
        const double wanted = 0.5 / std::sqrt(-second);
        step_[i] = std::clamp(wanted, 0.02 * h, 5 * h);
        if (parameters_[i].logarithmic) step_[i] = std::min(step_[i], 0.5);
      } else if (std::abs(plus[i] - minus) < 1) {
        step_[i] = std::min(2 * h, parameters_[i].logarithmic ? 0.5 : 2 * h);
      }
    }
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < i; ++k) {
        if (shifted_[i] || shifted_[k]) continue;
        if (!correlations) {
          const double was = before(i, i) * before(k, k), is = curvature_(i, i) * curvature_(k, k);
          if (was > 0 && is > 0) {
            curvature_(i, k) = curvature_(k, i) = before(i, k) * std::sqrt(is / was);
            continue;
          }
        }
        VectorXd a = z_;
        a[i] += used_[i], a[k] += used_[k];
        VectorXd b = z_;
        b[i] -= used_[i], b[k] -= used_[k];
        const double diagonal =
            0.5 * (curvature_(i, i) * used_[i] * used_[i] + curvature_(k, k) * used_[k] * used_[k]);
        const double mixed = (value(a) + value(b) - 2 * here) / 2 + diagonal;
        curvature_(i, k) = curvature_(k, i) = -mixed / (used_[i] * used_[k]);
      }
    }
  }

  // Of minus the log-likelihood; where it has no minimum, as if it curved upwards as much.
  Parabola parabola() const {
    Parabola out{curvature_, -gradient_, box_.held(z_, -gradient_)};
    for (int i = 0; i < n_; ++i) out.curvature(i, i) = std::max(std::abs(curvature_(i, i)), 1e-12);
    return out;
  }

  void finish(Maximum& out, double here) {
    out.log_likelihood = here;
    out.covariance.assign(static_cast<size_t>(n_) * n_, 0);
    // Directions without curvature have no estimate.
    const auto [covariance, known] = covariance_of(curvature_, 1e-10);
    for (int i = 0; i < n_; ++i) {
      const SearchParameter& p = parameters_[i];
      out.value.push_back(p.logarithmic ? std::exp(z_[i]) : z_[i]);
      out.at_bound.push_back(z_[i] <= box_.low[i] || z_[i] >= box_.high[i]);
      const double jacobian = p.logarithmic ? out.value[i] : 1;
      out.sigma.push_back(known[i] ? jacobian * std::sqrt(covariance(i, i))
                                   : std::numeric_limits<double>::infinity());
    }
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < n_; ++k) {
        const double ji = parameters_[i].logarithmic ? out.value[i] : 1;
        const double jk = parameters_[k].logarithmic ? out.value[k] : 1;
        out.covariance[static_cast<size_t>(i) * n_ + k] = ji * jk * covariance(i, k);
      }
    }
  }

  const std::function<double(const std::vector<double>&)>& f_;
  const std::vector<SearchParameter>& parameters_;
  int n_;
  VectorXd z_;
  Box box_;
  VectorXd step_, gradient_;
  VectorXd used_ = VectorXd::Zero(n_), shifted_ = VectorXd::Zero(n_);
  MatrixXd curvature_;
  bool settled_ = false;
};

}  // namespace

Maximum maximise(const std::function<double(const std::vector<double>&)>& log_likelihood,
                 const std::vector<SearchParameter>& parameters) {
  return Search(log_likelihood, parameters).run();
}

}  // namespace seam::measurement
