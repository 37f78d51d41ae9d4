// The default fit: Levenberg-Marquardt on whitened residuals for parameters of the mean, Newton
// steps on the log-likelihood for parameters of the spread, in turn until neither moves.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {
namespace {

const effects::Parameter& parameter_of(const Model& model, const Unknown& unknown) {
  return model.find(unknown.effect)->definition->parameters[unknown.parameter];
}

double value_of(const Model& model, const Unknown& unknown) {
  return model.find(unknown.effect)->parameters[unknown.parameter].value;
}

void set_value(Model& model, const Unknown& unknown, double value) {
  model.set_value(unknown.effect, unknown.parameter, value);
}

bool is_spread(const Model& model, const Unknown& unknown) {
  return model.find(unknown.effect)->definition->spread_only;
}

double step_of(const effects::Parameter& parameter, double value) {
  const double size = std::max(parameter.scale, std::abs(value));
  const double step = 1e-4 * (std::isfinite(size) ? size : parameter.scale);
  return value + step > parameter.max ? -step : step;
}

double objective(const Problem& problem, const Evaluation& evaluation) {
  if (!evaluation.valid) return std::numeric_limits<double>::infinity();
  return -score_of(problem, evaluation).log_likelihood;
}

// The state of one fit.
class Fitter {
 public:
  Fitter(const Problem& problem, const Model& start, const std::vector<Unknown>& unknowns,
         const Groups& groups)
      : problem_(problem),
        groups_(groups),
        unknowns_(unknowns),
        model_(start),
        here_(problem.evaluate(start, groups)) {
    value_ = objective(problem_, here_);
    for (size_t i = 0; i < unknowns.size(); ++i) {
      (is_spread(start, unknowns[i]) ? spread_ : mean_).push_back(i);
    }
    count_ = static_cast<size_t>(std::count(here_.used.begin(), here_.used.end(), 1));
  }

  Fit run() {
    bool converged = mean_.empty();
    for (int round = 0; round < 6; ++round) {
      const double before = value_;
      if (!mean_.empty()) converged = fit_mean();
      fit_spread();
      if ((spread_.empty() && !here_.reusable) || before - value_ < 1e-3) break;
      if (here_.reusable) renew();
    }
    return result(converged);
  }

 private:
  bool fit_mean();
  void fit_spread();
  // What evaluations reused on the way is computed again.
  void renew() {
    here_ = problem_.evaluate(model_, groups_);
    value_ = objective(problem_, here_);
  }
  void newton_spread(const Unknown& unknown);
  Fit result(bool converged);
  bool try_model(const Model& candidate);
  Eigen::MatrixXd mean_jacobian();

  const Problem& problem_;
  const Groups& groups_;
  const std::vector<Unknown>& unknowns_;
  Model model_;
  Evaluation here_;
  double value_ = 0;  // Negative log-likelihood.
  size_t count_ = 0;  // Residuals.
  std::vector<size_t> mean_;
  std::vector<size_t> spread_;
};

Eigen::MatrixXd Fitter::mean_jacobian() {
  std::vector<Unknown> chosen;
  for (size_t i : mean_) chosen.push_back(unknowns_[i]);
  const auto columns = problem_.jacobian(model_, chosen, groups_, here_);
  Eigen::MatrixXd jacobian(columns.front().size(), columns.size());
  for (size_t i = 0; i < columns.size(); ++i) {
    jacobian.col(i) = Eigen::Map<const Eigen::VectorXd>(columns[i].data(), columns[i].size());
  }
  return jacobian;
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

bool Fitter::fit_mean() {
  if (!here_.valid) return false;
  double damping = 1e-6;
  for (int iteration = 0; iteration < 40; ++iteration) {
    const Eigen::MatrixXd jacobian = mean_jacobian();
    const Eigen::Map<const Eigen::VectorXd> z(here_.whitened.data(), here_.whitened.size());
    const Eigen::MatrixXd hessian = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * z;
    const double before = value_;
    // A gain of this much log-likelihood moves no estimate by more than a few hundredths of its
    // sigma; where the model misses more than the noise, it is worth less in proportion.
    const double enough =
        1e-3 * std::max(1.0, z.squaredNorm() / static_cast<double>(std::max<size_t>(1, count_)));
    double predicted = 0;
    bool accepted = false;
    for (int attempt = 0; attempt < 12 && !accepted; ++attempt) {
      // Parameters without leverage, or held by a bound, stay.
      std::vector<int> moving;
      for (size_t i = 0; i < mean_.size(); ++i) {
        const effects::Parameter& parameter = parameter_of(model_, unknowns_[mean_[i]]);
        const double value = value_of(model_, unknowns_[mean_[i]]);
        const bool held = (value <= parameter.min && gradient[i] > 0) ||
                          (value >= parameter.max && gradient[i] < 0);
        if (hessian(i, i) > 0 && !held) moving.push_back(static_cast<int>(i));
      }
      if (moving.empty()) return true;
      // Scaled to a unit diagonal, so that units do not matter.
      Eigen::MatrixXd scaled(moving.size(), moving.size());
      Eigen::VectorXd right(moving.size());
      for (size_t a = 0; a < moving.size(); ++a) {
        right[a] = -gradient[moving[a]] / std::sqrt(hessian(moving[a], moving[a]));
        for (size_t b = 0; b < moving.size(); ++b) {
          scaled(a, b) = hessian(moving[a], moving[b]) /
                         std::sqrt(hessian(moving[a], moving[a]) * hessian(moving[b], moving[b]));
        }
        scaled(a, a) += damping + 1e-12;
      }
      const Eigen::VectorXd step = solve_symmetric(scaled, right);
      predicted = 0.5 * step.dot(right);
      Model candidate = model_;
      for (size_t a = 0; a < moving.size(); ++a) {
        const Unknown& unknown = unknowns_[mean_[moving[a]]];
        const effects::Parameter& parameter = parameter_of(model_, unknown);
        const double moved =
            value_of(model_, unknown) + step[a] / std::sqrt(hessian(moving[a], moving[a]));
        set_value(candidate, unknown, std::clamp(moved, parameter.min, parameter.max));
      }
      if (predicted < 0.1 * enough) return true;
      accepted = try_model(candidate);
      damping = accepted ? damping * 0.1 : std::max(damping * 10, 1e-4);
    }
    if (!accepted) return predicted < 10 * enough;
    if (before - value_ < 0.1 * enough) return true;
  }
  return false;
}

void Fitter::fit_spread() {
  for (int sweep = 0; sweep < (spread_.size() > 1 ? 8 : 1); ++sweep) {
    const double before = value_;
    for (size_t i : spread_) newton_spread(unknowns_[i]);
    if (before - value_ < 1e-4) break;
  }
}

// Newton in the square of a sigma, in which the likelihood is smooth at zero.
void Fitter::newton_spread(const Unknown& unknown) {
  const effects::Parameter parameter = parameter_of(model_, unknown);
  const auto at = [&](double square) {
    Model candidate = model_;
    set_value(candidate, unknown,
              std::clamp(std::sqrt(std::max(square, 0.0)), parameter.min, parameter.max));
    return candidate;
  };
  const auto cost = [&](double square) {
    return objective(problem_, problem_.evaluate(at(square), groups_, &here_));
  };
  for (int iteration = 0; iteration < 25; ++iteration) {
    const double value = value_of(model_, unknown);
    const double square = value * value;
    const double floor = 1e-3 * parameter.scale;
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
  const size_t count = unknowns_.size();
  Fit fit{
      .model = model_, .log_likelihood = -value_, .converged = converged && std::isfinite(value_)};
  fit.sigma.assign(count, std::numeric_limits<double>::infinity());
  fit.covariance.assign(count * count, 0);
  for (const Unknown& unknown : unknowns_) {
    const effects::Parameter& parameter = parameter_of(model_, unknown);
    const double value = value_of(model_, unknown);
    fit.value.push_back(value);
    fit.at_bound.push_back((value <= parameter.min && parameter.min != parameter.neutral) ||
                           (value >= parameter.max && parameter.max != parameter.neutral));
  }
  if (!here_.valid) return fit;
  if (!mean_.empty()) {
    const Eigen::MatrixXd jacobian = mean_jacobian();
    const Eigen::MatrixXd information = jacobian.transpose() * jacobian;
    std::vector<int> known;
    for (size_t i = 0; i < mean_.size(); ++i) {
      if (information(i, i) > 0) known.push_back(static_cast<int>(i));
    }
    Eigen::MatrixXd scaled(known.size(), known.size());
    for (size_t a = 0; a < known.size(); ++a) {
      for (size_t b = 0; b < known.size(); ++b) {
        scaled(a, b) = information(known[a], known[b]) /
                       std::sqrt(information(known[a], known[a]) * information(known[b], known[b]));
      }
    }
    // A misfit larger than the noise makes estimates less certain in proportion.
    const Score score = score_of(problem_, here_);
    const double misfit = std::max(1.0, score.error());
    const Eigen::MatrixXd covariance = floored_inverse(scaled, 1e-13);
    for (size_t a = 0; a < known.size(); ++a) {
      const size_t i = mean_[known[a]];
      for (size_t b = 0; b < known.size(); ++b) {
        fit.covariance[i * count + mean_[known[b]]] =
            misfit * misfit * covariance(a, b) /
            std::sqrt(information(known[a], known[a]) * information(known[b], known[b]));
      }
      fit.sigma[i] = std::sqrt(fit.covariance[i * count + i]);
    }
  }
  for (size_t i : spread_) {
    // Curvature of the likelihood, parameter by parameter.
    const effects::Parameter& parameter = parameter_of(model_, unknowns_[i]);
    const double value = value_of(model_, unknowns_[i]);
    const double h = std::max(0.05 * std::abs(value), 1e-3 * parameter.scale);
    const auto cost = [&](double at) {
      Model candidate = model_;
      set_value(candidate, unknowns_[i], std::clamp(at, parameter.min, parameter.max));
      return objective(problem_, problem_.evaluate(candidate, groups_, &here_));
    };
    const double curvature =
        (cost(value + h) - 2 * cost(value) + cost(std::abs(value - h))) / (h * h);
    if (curvature > 0) fit.sigma[i] = 1 / std::sqrt(curvature);
    fit.covariance[i * count + i] = fit.sigma[i] * fit.sigma[i];
  }
  return fit;
}

}  // namespace

std::vector<std::vector<double>> Problem::jacobian(const Model& model,
                                                   const std::vector<Unknown>& unknowns,
                                                   const Groups& groups,
                                                   const Evaluation& here) const {
  std::vector<std::vector<double>> columns;
  for (const Unknown& unknown : unknowns) {
    const double value = value_of(model, unknown);
    double step = step_of(parameter_of(model, unknown), value);
    Model moved = model;
    set_value(moved, unknown, value + step);
    Evaluation there = evaluate(moved, groups, &here);
    if (!there.valid) {
      step = -step;
      set_value(moved, unknown, value + step);
      there = evaluate(moved, groups, &here);
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
  return Fitter(*this, start, unknowns, groups).run();
}

}  // namespace seam::measurement
