#include "measurement/fitting/parameter_space.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace seam::measurement {

Coordinate::Coordinate(const Model& model, const Unknown& which) : unknown(which) {
  const EffectDefinition& effect = *model.find(which.effect)->definition;
  parameter = &effect.parameters[which.parameter];
  const effects::Parameter& p = *parameter;
  min = p.fit_reciprocal ? 0 : p.min;
  max = p.fit_reciprocal ? 1 / std::max(p.min, 1e-300) : p.max;
  scale = p.fit_reciprocal ? 1 / p.scale : p.scale;
  spread = effect.spread_only;
}

double Coordinate::to_value(double z) const {
  if (!parameter->fit_reciprocal) return z;
  return z > 0 ? 1 / z : std::numeric_limits<double>::infinity();
}

double Coordinate::slope(double z) const {
  if (!parameter->fit_reciprocal) return 1;
  return z > 0 ? -1 / (z * z) : -std::numeric_limits<double>::infinity();
}

double Coordinate::of(const Model& model) const {
  const double value = model.find(unknown.effect)->parameters[unknown.parameter].value;
  return std::clamp(parameter->fit_reciprocal ? 1 / value : value, min, max);
}

void Coordinate::set(Model& model, double z) const {
  model.set_value(unknown.effect, unknown.parameter, to_value(z));
}

bool Coordinate::at_bound(double z) const {
  const double neutral = parameter->fit_reciprocal ? 0 : parameter->neutral;
  return (z <= min && min != neutral) || (z >= max && max != neutral);
}

ParameterSpace::ParameterSpace(const Model& model, const std::vector<Unknown>& unknowns) {
  const auto count = static_cast<Eigen::Index>(unknowns.size());
  box_ = {Eigen::VectorXd(count), Eigen::VectorXd(count)};
  for (const Unknown& unknown : unknowns) {
    const auto i = static_cast<Eigen::Index>(coordinates_.size());
    const Coordinate& c = coordinates_.emplace_back(model, unknown);
    box_.low[i] = c.min, box_.high[i] = c.max;
  }
}

bool ParameterSpace::any_of_mean() const {
  return std::any_of(begin(), end(), [](const Coordinate& c) { return !c.spread; });
}

Eigen::VectorXd ParameterSpace::untold() const {
  // In scales, the error of what is not told. One view of a board that faces the camera tells
  // neither focal length nor centre: the best of half its corners lay at 2,600 px, where the other
  // half had no pose.
  constexpr double kOutOfReach = 100;
  Eigen::VectorXd out(static_cast<Eigen::Index>(size()));
  for (size_t i = 0; i < size(); ++i)
    out[static_cast<Eigen::Index>(i)] = std::pow(kOutOfReach * coordinates_[i].scale, -2);
  return out;
}

Eigen::VectorXd ParameterSpace::place(const Model& model) const {
  Eigen::VectorXd place(static_cast<Eigen::Index>(size()));
  for (size_t i = 0; i < size(); ++i)
    place[static_cast<Eigen::Index>(i)] = coordinates_[i].of(model);
  return place;
}

Model ParameterSpace::at(Model model, const Eigen::VectorXd& place) const {
  for (size_t i = 0; i < size(); ++i)
    coordinates_[i].set(model, place[static_cast<Eigen::Index>(i)]);
  return model;
}

Model ParameterSpace::with(Model model, size_t i, double z) const {
  coordinates_[i].set(model, std::clamp(z, coordinates_[i].min, coordinates_[i].max));
  return model;
}

Fit ParameterSpace::fit_at(const Model& model, const Eigen::VectorXd& place, double log_likelihood,
                           bool converged) const {
  Fit fit{.model = at(model, place), .log_likelihood = log_likelihood, .converged = converged};
  for (size_t i = 0; i < size(); ++i) {
    const double z = place[static_cast<Eigen::Index>(i)];
    fit.value.push_back(coordinates_[i].to_value(z));
    fit.at_bound.push_back(coordinates_[i].at_bound(z));
  }
  fit.sigma.assign(size(), std::numeric_limits<double>::infinity());
  fit.covariance.assign(size() * size(), 0);
  return fit;
}

void ParameterSpace::state(const Covariance& covariance, double misfit,
                           const Eigen::VectorXd& place, Fit& fit) const {
  std::vector<double> rate(size());  // 0 where nothing can be said of the value.
  for (size_t i = 0; i < size(); ++i) {
    const double slope = coordinates_[i].slope(place[static_cast<Eigen::Index>(i)]);
    rate[i] = covariance.known[i] && std::isfinite(slope) ? misfit * slope : 0;
  }
  for (size_t i = 0; i < size(); ++i) {
    for (size_t k = 0; k < size(); ++k) {
      fit.covariance[i * size() + k] =
          rate[i] * rate[k] *
          covariance.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    }
    if (rate[i] != 0) fit.sigma[i] = std::sqrt(fit.covariance[i * size() + i]);
  }
}

void ParameterSpace::state(size_t i, double sigma, double z, Fit& fit) const {
  const double slope = coordinates_[i].slope(z);
  fit.sigma[i] =
      std::isfinite(slope) ? std::abs(slope) * sigma : std::numeric_limits<double>::infinity();
  fit.covariance[i * size() + i] = std::isfinite(fit.sigma[i]) ? fit.sigma[i] * fit.sigma[i] : 0;
}

double misfit_of(const Problem& problem, const Evaluation& evaluation) {
  return std::max(1.0, score_of(problem, evaluation).error());
}

double spread_error(const Problem& problem, const ParameterSpace& space, size_t i,
                    const Model& model, const Groups& groups, const Evaluation* warm,
                    double share) {
  const double z = space[i].of(model);
  return sigma_of_spread(
      [&](double at) {
        const Evaluation there = problem.evaluate(space.with(model, i, at), groups, warm);
        return there.valid ? -log_likelihood_of(problem, there)
                           : std::numeric_limits<double>::infinity();
      },
      z, std::max(share * z, 1e-3 * space[i].scale));
}

}  // namespace seam::measurement
