#include "measurement/numerics/maximise.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/numerics/box.h"
#include "measurement/numerics/curvature.h"
#include "measurement/numerics/damped_step.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Search {
 public:
  Search(const std::function<double(const std::vector<double>&)>& f,
         const std::vector<SearchParameter>& parameters, Calls calls,
         const std::vector<double>& alike)
      : f_(f),
        parameters_(parameters),
        calls_(calls),
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
    start_ = z_;
    correlations_given_ = !alike.empty();
    if (correlations_given_) curvature_ = Eigen::Map<const MatrixXd>(alike.data(), n_, n_);
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
    bool misled = !correlations_given_;
    for (int iteration = 0; iteration < kMostSteps && n_ > 0; ++iteration) {
      // Parameters' correlations change little between most steps: they are measured at the start,
      // at the end, and where a step gained less than they promised.
      derivatives(here, misled || (settled_ && !correlations_given_));
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

  std::vector<double> values(const std::vector<VectorXd>& places) const {
    std::vector<double> out(places.size());
    parallel_for(
        places.size(), [&](size_t i) { out[i] = value(places[i]); }, calls_ == Calls::side_by_side);
    return out;
  }

  void derivatives(double here, bool correlations) {
    const MatrixXd before = curvature_;
    gradient_ = VectorXd::Zero(n_);
    curvature_ = MatrixXd::Zero(n_, n_);
    along_axes(here);
    across_axes(here, correlations ? MatrixXd::Zero(n_, n_) : before);
  }

  void along_axes(double here) {
    std::vector<VectorXd> places;  // Of each parameter: middle, above, below.
    VectorXd middles(n_);
    for (int i = 0; i < n_; ++i) {
      // Inside the bounds, one-sided where they are near.
      const double h = std::min(step_[i], 0.5 * (box_.high[i] - box_.low[i]));
      double& middle = middles[i] = z_[i];
      if (middle + h > box_.high[i]) middle = box_.high[i] - h;
      if (middle - h < box_.low[i]) middle = box_.low[i] + h;
      used_[i] = h, shifted_[i] = middle != z_[i];
      places.insert(places.end(), 3, z_);
      places[3 * i][i] = middle, places[3 * i + 1][i] = middle + h;
      places[3 * i + 2][i] = middle - h;
    }
    std::vector<VectorXd> asked;
    for (int i = 0; i < 3 * n_; ++i)
      if (i % 3 != 0 || shifted_[i / 3]) asked.push_back(places[i]);
    const std::vector<double> found = values(asked);
    auto next = found.begin();
    for (int i = 0; i < n_; ++i) {
      const double h = used_[i], middle = shifted_[i] ? *next++ : here;
      const double plus = *next++, minus = *next++;
      const double second = (plus - 2 * middle + minus) / (h * h);
      gradient_[i] = (plus - minus) / (2 * h) + second * (z_[i] - middles[i]);
      curvature_(i, i) = -second;
      if (-second > 0) {
        const double wanted = 0.5 / std::sqrt(-second);
        step_[i] = std::clamp(wanted, 0.02 * h, 5 * h);
        if (parameters_[i].logarithmic) step_[i] = std::min(step_[i], 0.5);
      } else if (std::abs(plus - minus) < 1) {
        step_[i] = std::min(2 * h, parameters_[i].logarithmic ? 0.5 : 2 * h);
      }
    }
  }

  // Correlations as in `before` where that has them.
  void across_axes(double here, const MatrixXd& before) {
    std::vector<std::pair<int, int>> pairs;
    std::vector<VectorXd> places;
    for (int i = 0; i < n_; ++i) {
      for (int k = 0; k < i; ++k) {
        if (shifted_[i] || shifted_[k]) continue;
        const double was = before(i, i) * before(k, k), is = curvature_(i, i) * curvature_(k, k);
        if (was > 0 && is > 0) {
          curvature_(i, k) = curvature_(k, i) = before(i, k) * std::sqrt(is / was);
          continue;
        }
        pairs.emplace_back(i, k);
        places.insert(places.end(), 2, z_);
        VectorXd &a = places[places.size() - 2], &b = places.back();
        a[i] += used_[i], a[k] += used_[k];
        b[i] -= used_[i], b[k] -= used_[k];
      }
    }
    const std::vector<double> found = values(places);
    for (size_t j = 0; j < pairs.size(); ++j) {
      const auto [i, k] = pairs[j];
      const double diagonal =
          0.5 * (curvature_(i, i) * used_[i] * used_[i] + curvature_(k, k) * used_[k] * used_[k]);
      const double mixed = (found[2 * j] + found[2 * j + 1] - 2 * here) / 2 + diagonal;
      curvature_(i, k) = curvature_(k, i) = -mixed / (used_[i] * used_[k]);
    }
  }

  // Of minus the log-likelihood; where it has no minimum, as if it curved upwards as much.
  Parabola parabola() const {
    Parabola out{curvature_, -gradient_, box_.held(z_, -gradient_)};
    for (int i = 0; i < n_; ++i) out.curvature(i, i) = std::max(std::abs(curvature_(i, i)), 1e-12);
    return out;
  }

  // How far both ways along a direction lead inside the bounds.
  double room(const VectorXd& way) const {
    double most = std::numeric_limits<double>::infinity();
    for (int i = 0; i < n_; ++i) {
      const double inside = std::min(box_.high[i] - z_[i], z_[i] - box_.low[i]);
      if (way[i] != 0) most = std::min(most, inside / std::abs(way[i]));
    }
    return most;
  }

  // The curvature along a direction over about a standard error; `by_axes` is what differences
  // along the axes say.
  double along(double here, const VectorXd& way, double by_axes) const {
    constexpr double kStandard = 0.5, kLeast = 0.1, kMost = 2;  // Falls of the log-likelihood.
    constexpr double kFarther = 4, kNearer = 0.1, kLeastByAxes = 1e-6;
    const double most = room(way);
    double far = 1 / std::sqrt(std::max(by_axes, kLeastByAxes)), curvature = std::max(by_axes, 0.0);
    for (int attempt = 0; attempt < 8 && most > 0; ++attempt) {
      far = std::min(far, most);
      const double fall = here - 0.5 * (value(z_ + far * way) + value(z_ - far * way));
      curvature = std::max(0.0, 2 * fall / (far * far));
      if (fall > kMost) {
        far *= std::max(kNearer, std::sqrt(kStandard / fall));
      } else if (fall < kLeast && far < most) {
        far *= kFarther;
      } else {
        break;
      }
    }
    return curvature;
  }

  // Differences along the axes tell a direction in which parameters make up for each other as what
  // is left of large numbers: such directions are measured along themselves.
  MatrixXd information(double here) const {
    constexpr double kWeak = 0.05;  // Of what single parameters have.
    MatrixXd out = curvature_;
    std::vector<Eigen::Index> known;
    for (int i = 0; i < n_; ++i) {
      if (curvature_(i, i) > 0) known.push_back(i);
    }
    if (known.empty()) return out;
    const VectorXd scale = curvature_.diagonal()(known).cwiseSqrt();
    const MatrixXd unit = scale.cwiseInverse().asDiagonal() * curvature_(known, known) *
                          scale.cwiseInverse().asDiagonal();
    SymmetricEigen eigen = symmetric_eigen(unit);
    for (Eigen::Index k = 0; k < eigen.values.size() && eigen.values[k] < kWeak; ++k) {
      VectorXd way = VectorXd::Zero(n_);
      way(known) = scale.cwiseInverse().cwiseProduct(eigen.vectors.col(k));
      eigen.values[k] = along(here, way, eigen.values[k]);
    }
    out(known, known) = scale.asDiagonal() * eigen.vectors * eigen.values.asDiagonal() *
                        eigen.vectors.transpose() * scale.asDiagonal();
    return out;
  }

  // Where the likelihood says next to nothing, values lie anywhere in their range.
  void keep_to_ranges(MatrixXd& covariance) const {
    for (int i = 0; i < n_; ++i) {
      const double widest = (box_.high[i] - box_.low[i]) / std::sqrt(12.0);  // Of equal chances.
      const double sigma = std::sqrt(covariance(i, i));
      if (!(sigma > widest)) continue;
      covariance.row(i) *= widest / sigma;
      covariance.col(i) *= widest / sigma;
    }
  }

  bool is_at_end(int i) const { return z_[i] <= box_.low[i] || z_[i] >= box_.high[i]; }

  void finish(Maximum& out, double here) {
    out.log_likelihood = here;
    out.covariance.assign(static_cast<size_t>(n_) * n_, 0);
    out.curvature.assign(curvature_.data(), curvature_.data() + curvature_.size());
    // Directions without curvature have no estimate. One that drifted to an end of its range, where
    // the likelihood is no better than at its start, says nothing: it stays at its start.
    constexpr double kNoBetter = 0.5;  // Less than one standard error changes.
    const auto by_axes = covariance_of(curvature_, 1e-10);
    auto [covariance, known] = covariance_of(information(here), 1e-10);
    keep_to_ranges(covariance);
    for (int i = 0; i < n_; ++i) {
      if (known[i] || !is_at_end(i)) continue;
      VectorXd back = z_;
      back[i] = start_[i];
      if (here - value(back) < kNoBetter) z_ = back;
    }
    for (int i = 0; i < n_; ++i) {
      const SearchParameter& p = parameters_[i];
      out.value.push_back(p.logarithmic ? std::exp(z_[i]) : z_[i]);
      out.at_bound.push_back(is_at_end(i));
      out.step.push_back(step_[i]);
      const double jacobian = p.logarithmic ? out.value[i] : 1;
      out.sigma.push_back(known[i] ? jacobian * std::sqrt(covariance(i, i))
                                   : std::numeric_limits<double>::infinity());
      out.axis_sigma.push_back(jacobian * std::sqrt(std::max(0.0, by_axes.matrix(i, i))));
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
  const Calls calls_;
  int n_;
  VectorXd z_, start_;
  Box box_;
  VectorXd step_, gradient_;
  VectorXd used_ = VectorXd::Zero(n_), shifted_ = VectorXd::Zero(n_);
  MatrixXd curvature_;
  bool settled_ = false;
  bool correlations_given_ = false;
};

}  // namespace

Maximum maximise(const std::function<double(const std::vector<double>&)>& log_likelihood,
                 const std::vector<SearchParameter>& parameters, Calls calls,
                 const std::vector<double>& alike) {
  return Search(log_likelihood, parameters, calls, alike).run();
}

}  // namespace seam::measurement
