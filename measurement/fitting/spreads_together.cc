#include "measurement/fitting/spreads_together.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "measurement/numerics/linear_algebra.h"
#include "measurement/numerics/maximise.h"

namespace seam::measurement {
namespace {

constexpr double kWorthAnother = 0.02;  // What a further descent must have gained.

// Half of the standard deviation that each has beside the others, where all are known and small:
// across a narrow valley far less than that of the parameter itself.
void take_steps(const SpreadsTogether& before, std::vector<SearchParameter>& parameters) {
  const auto n = static_cast<Eigen::Index>(parameters.size());
  const Eigen::MatrixXd covariance =
      Eigen::Map<const Eigen::MatrixXd>(before.covariance.data(), n, n);
  const Eigen::VectorXd information = inverse_of(covariance).diagonal();
  std::vector<double> steps;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double value = before.place[static_cast<Eigen::Index>(before.which[k])];
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
    const double z = out.place[static_cast<Eigen::Index>(i)];
    if (space[i].spread && z > kNothing * space[i].scale && !space[i].parameter->fit_reciprocal)
      by_effect[space[i].unknown.effect].push_back(i);
  }
  for (const auto& [effect, places] : by_effect) {
    if (places.size() > 1) out.which.insert(out.which.end(), places.begin(), places.end());
  }
  if (out.which.empty()) return out;
  std::vector<SearchParameter> parameters;
  for (const size_t i : out.which) {
    parameters.push_back({.start = out.place[static_cast<Eigen::Index>(i)],
                          .min = std::max(space[i].min, 1e-4 * space[i].scale),
                          .max = space[i].max,
                          .step = 0.1,
                          .logarithmic = true});
  }
  if (before != nullptr && before->which == out.which) take_steps(*before, parameters);
  const auto log_likelihood = [&](const std::vector<double>& values) {
    Eigen::VectorXd place = out.place;
    for (size_t k = 0; k < values.size(); ++k)
      place[static_cast<Eigen::Index>(out.which[k])] = values[k];
    const Evaluation there = problem.evaluate(space.at(model, place), groups, warm);
    return there.valid ? score_of(problem, there).log_likelihood
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
    out.place[static_cast<Eigen::Index>(out.which[k])] = found.value[k];
  out.covariance = found.covariance;
  out.log_likelihood = found.log_likelihood;
  return out;
}

}  // namespace seam::measurement
