// Fits of whole images: renderings are dear, so parameters of the mean take few linear steps, and
// parameters of the spread, which need none, are sought on the likelihood in between.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/kinds/frames/frames.h"
#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/maximise.h"

namespace seam::measurement {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const effects::Parameter& parameter_of(const Model& model, const Unknown& unknown) {
  return model.find(unknown.effect)->definition->parameters[unknown.parameter];
}

double value_of(const Model& model, const Unknown& unknown) {
  return model.find(unknown.effect)->parameters[unknown.parameter].value;
}

class FrameFit {
 public:
  FrameFit(const FramesProblem& problem, const Model& start, const std::vector<Unknown>& unknowns,
           const Groups& groups)
      : problem_(problem),
        groups_(groups),
        unknowns_(unknowns),
        model_(start),
        here_(problem.evaluate(start, groups)) {
    likelihood_ = likelihood(here_);
    for (size_t i = 0; i < unknowns.size(); ++i) {
      (start.find(unknowns[i].effect)->definition->spread_only ? spread_ : mean_).push_back(i);
    }
  }

  Fit run() {
    Fit fit;
    fit.sigma.assign(unknowns_.size(), std::numeric_limits<double>::infinity());
    fit.covariance.assign(unknowns_.size() * unknowns_.size(), 0);
    fit.converged = mean_.empty();
    for (int round = 0; round < 8 && !mean_.empty() && here_.valid; ++round) {
      if (round == 1) fit_spread(fit);
      if (step(fit)) {
        fit.converged = true;
        break;
      }
    }
    if (here_.valid) fit_spread(fit);
    fit.model = model_;
    fit.log_likelihood = likelihood_;
    for (const Unknown& unknown : unknowns_) {
      const auto& parameter = parameter_of(model_, unknown);
      const double value = value_of(model_, unknown);
      fit.value.push_back(value);
      fit.at_bound.push_back((value <= parameter.min && parameter.min != parameter.neutral) ||
                             (value >= parameter.max && parameter.max != parameter.neutral));
    }
    return fit;
  }

 private:
  double likelihood(const Evaluation& evaluation) const {
    return evaluation.valid ? score_of(problem_, evaluation).log_likelihood
                            : -std::numeric_limits<double>::infinity();
  }

  // Half of what chi-square is above the number of values.
  double excess() const {
    double sum = 0;
    for (size_t i = 0; i < here_.used.size(); ++i) {
      if (here_.used[i]) sum += here_.whitened[i] * here_.whitened[i] - 1;
    }
    return std::max(0.0, 0.5 * sum);
  }

  // One linear step; true when it promises nothing more.
  bool step(Fit& fit) {
    std::vector<Unknown> chosen;
    for (const size_t i : mean_) chosen.push_back(unknowns_[i]);
    const auto columns = problem_.jacobian(model_, chosen, groups_, here_);
    const auto count = static_cast<Eigen::Index>(columns.size());
    MatrixXd normal(count, count);
    VectorXd right(count);
    const Eigen::Map<const VectorXd> z(here_.whitened.data(),
                                       static_cast<Eigen::Index>(here_.whitened.size()));
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Map<const VectorXd> a(columns[i].data(), z.size());
      right[i] = -a.dot(z);
      for (Eigen::Index k = 0; k <= i; ++k) {
        normal(i, k) = normal(k, i) =
            a.dot(Eigen::Map<const VectorXd>(columns[k].data(), z.size()));
      }
    }
    VectorXd scale(count);
    for (Eigen::Index i = 0; i < count; ++i)
      scale[i] = normal(i, i) > 0 ? 1 / std::sqrt(normal(i, i)) : 0;
    MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
    for (Eigen::Index i = 0; i < count; ++i) unit(i, i) += scale[i] > 0 ? 1e-10 : 1;
    const MatrixXd covariance =
        scale.asDiagonal() * floored_inverse(unit, 1e-13) * scale.asDiagonal();
    for (Eigen::Index i = 0; i < count; ++i) {
      if (scale[i] > 0) fit.sigma[mean_[i]] = std::sqrt(covariance(i, i));
      for (Eigen::Index k = 0; k < count; ++k)
        fit.covariance[mean_[i] * unknowns_.size() + mean_[k]] = covariance(i, k);
    }
    double damping = 0;
    for (int attempt = 0; attempt < 4; ++attempt) {
      MatrixXd damped = unit;
      damped.diagonal().array() += damping;
      const VectorXd scaled_right = scale.cwiseProduct(right);
      const VectorXd scaled = solve_symmetric(damped, scaled_right);
      const double promised = 0.5 * scaled.dot(scaled_right);
      Model candidate = model_;
      for (Eigen::Index i = 0; i < count; ++i) {
        const Unknown& unknown = unknowns_[mean_[i]];
        const auto& parameter = parameter_of(model_, unknown);
        candidate.set_value(unknown.effect, unknown.parameter,
                            std::clamp(value_of(model_, unknown) + scale[i] * scaled[i],
                                       parameter.min, parameter.max));
      }
      if (promised < 0.02) return true;
      Evaluation there = problem_.evaluate(candidate, groups_);
      const double value = likelihood(there);
      if (value > likelihood_) {
        const double gained = value - likelihood_;
        model_ = std::move(candidate);
        here_ = std::move(there);
        likelihood_ = value;
        // What is left after a step of linear size is below the renderer's own differences; a model
        // that is far off needs no exact optimum.
        return gained < std::max(0.5, 0.004 * excess()) || promised < 2;
      }
      if (promised < 1) return true;
      damping = damping == 0 ? 0.3 : damping * 8;
    }
    return true;
  }

  // Parameters of the spread that are sought on the likelihood of some groups, from where the model
  // stands.
  Maximum search_spread(const Groups& groups) {
    std::vector<SearchParameter> parameters;
    for (const size_t i : spread_) {
      const auto& parameter = parameter_of(model_, unknowns_[i]);
      const double value = value_of(model_, unknowns_[i]);
      const bool positive = parameter.min >= 0 && value > 0;
      parameters.push_back(
          {.start = value,
           .min = positive ? std::max(parameter.min, 1e-5 * parameter.scale) : parameter.min,
           .max = parameter.max,
           .step = positive ? 0.05 : 0.05 * parameter.scale,
           .logarithmic = positive});
    }
    Model model = model_;
    return maximise(
        [&](const std::vector<double>& values) {
          set_spread(model, values);
          return likelihood(problem_.evaluate(model, groups));
        },
        parameters);
  }

  void set_spread(Model& model, const std::vector<double>& values) const {
    for (size_t k = 0; k < spread_.size(); ++k) {
      const Unknown& unknown = unknowns_[spread_[k]];
      model.set_value(unknown.effect, unknown.parameter, values[k]);
    }
  }

  // Two frames hold as many samples as a spread needs to be found: all frames only make it exact,
  // and that only where it helps the two at all (one that helps all by five standard errors fails
  // here once in 40).
  bool helps_on_few() {
    constexpr double kHelps = 0.05;  // Gain of log-likelihood.
    std::vector<size_t> chosen;
    for (size_t g = 0; g < groups_.size(); ++g) {
      if (groups_[g]) chosen.push_back(g);
    }
    if (chosen.size() < 4) return true;
    Groups few(groups_.size(), 0);
    few[chosen[chosen.size() / 4]] = few[chosen[3 * chosen.size() / 4]] = 1;
    const Maximum maximum = search_spread(few);
    std::vector<double> neutral;
    for (const size_t i : spread_) neutral.push_back(parameter_of(model_, unknowns_[i]).neutral);
    Model without = model_;
    set_spread(without, neutral);
    set_spread(model_, maximum.value);
    here_ = problem_.evaluate(model_, groups_);
    likelihood_ = likelihood(here_);
    return maximum.log_likelihood > likelihood(problem_.evaluate(without, few)) + kHelps;
  }

  void fit_spread(Fit& fit) {
    if (spread_.empty()) return;
    if (!searched_ && !helps_on_few()) return;
    searched_ = true;
    const Maximum maximum = search_spread(groups_);
    Model model = model_;
    set_spread(model, maximum.value);
    for (size_t k = 0; k < spread_.size(); ++k) {
      fit.sigma[spread_[k]] = maximum.sigma[k];
      for (size_t j = 0; j < spread_.size(); ++j) {
        fit.covariance[spread_[k] * unknowns_.size() + spread_[j]] =
            maximum.covariance[k * spread_.size() + j];
      }
    }
    if (maximum.log_likelihood < likelihood_) return;
    model_ = model;
    here_ = problem_.evaluate(model_, groups_);
    likelihood_ = maximum.log_likelihood;
  }

  const FramesProblem& problem_;
  const Groups& groups_;
  const std::vector<Unknown>& unknowns_;
  Model model_;
  Evaluation here_;
  double likelihood_ = 0;
  std::vector<size_t> mean_, spread_;
  bool searched_ = false;  // Whether the spread stands where some frames want it.
};

}  // namespace

Fit FramesProblem::fit(const Model& start, const std::vector<Unknown>& unknowns,
                       const Groups& groups) const {
  return FrameFit(*this, start, unknowns, groups).run();
}

}  // namespace seam::measurement
