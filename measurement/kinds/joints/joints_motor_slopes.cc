// How predictions of servos with torque change with their parameters, and the errors of a fit.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "measurement/fitting/parameter_space.h"
#include "measurement/kinds/joints/joints.h"
#include "measurement/numerics/curvature.h"
#include "measurement/numerics/parallel_for.h"

namespace seam::measurement {
namespace {

using Values = std::vector<double>;

// Takes out of a list, over the rows where `part` says so, what a column makes of it.
void take_out(const std::vector<double>& of, std::vector<double>& from,
              const std::vector<size_t>& rows) {
  double along = 0, norm = 0;
  for (const size_t i : rows) along += of[i] * from[i], norm += of[i] * of[i];
  if (!(norm > 0)) return;
  for (const size_t i : rows) from[i] -= along / norm * of[i];
}

}  // namespace

// Logs are independent of each other: all their starts are moved at once.
void JointsProblem::take_out_starts(const Model& model, const Groups& groups,
                                    const Evaluation& here, std::vector<Values>& columns) const {
  const double by_rad = here.sigma.empty() ? 0 : facts_.channels[0].noise, by_radps = 0.01;
  const auto slope = [&](double rad, double radps) {
    Evaluation moved;
    moved.nuisance_values = here.nuisance_values, moved.reusable = here.reusable;
    size_t place = 0;
    for (const JointLog& log : set_.logs) {
      if (!groups[facts_.group_of_row[log.rows[0]]]) continue;
      moved.nuisance_values.at(place) += rad;
      if (unknowns_of_start(model, log) > 1) moved.nuisance_values.at(place + 1) += radps;
      place += kStartValues;
    }
    const Evaluation there = evaluate(model, groups, &moved);
    return change_of(model, here, there);
  };
  const Values by_angle = slope(by_rad, 0);
  const bool any_rate = std::any_of(set_.logs.begin(), set_.logs.end(), [&](const JointLog& log) {
    return unknowns_of_start(model, log) > 1;
  });
  Values by_rate = any_rate ? slope(0, by_radps) : Values();
  size_t place = 0;
  for (const JointLog& log : set_.logs) {
    if (!groups[facts_.group_of_row[log.rows[0]]]) continue;
    const double offset_rad = here.nuisance_values.at(place);
    place += kStartValues;
    // A start that is held near where it was measured is not free.
    if (std::abs(offset_rad) >= kFarthestStart * here.sigma[log.rows[0]]) continue;
    std::vector<size_t> scalars = log.rows;
    for (const size_t row : log.rows) {
      if (has_efforts() && effort_scalar_[row] >= 0) scalars.push_back(effort_scalar_[row]);
    }
    if (any_rate) take_out(by_angle, by_rate, scalars);
    for (Values& column : columns) {
      take_out(by_angle, column, scalars);
      if (any_rate) take_out(by_rate, column, scalars);
    }
  }
}

// Differences over these steps of the parameters, with the starts of the logs as they are; what
// these could do about a column is taken out of it, so that errors know of them.
std::vector<Values> JointsProblem::differences(const ParameterSpace& space, const Model& model,
                                               const Groups& groups, const Evaluation& here,
                                               const std::vector<double>& steps,
                                               bool both_sides) const {
  std::vector<Values> columns(space.size());
  parallel_for(space.size(), [&](size_t at) {
    const Coordinate& c = space[at];
    const double z = c.of(model);
    const double slope = std::isfinite(c.slope(z)) ? c.slope(z) : 1;
    double step = steps[at] / std::abs(slope);
    if (z + step > c.max) step = -step;
    const auto changed_by = [&](double by) {
      Model moved = model;
      c.set(moved, z + by);
      return change_of(moved, here, evaluate(moved, groups, &here));
    };
    columns[at] = changed_by(step);
    const bool both = both_sides && z - step >= c.min && z - step <= c.max;
    const Values back = both ? changed_by(-step) : Values(columns[at].size(), 0);
    for (size_t i = 0; i < back.size(); ++i)
      columns[at][i] = (columns[at][i] - back[i]) / ((both ? 2 : 1) * step * slope);
  });
  take_out_starts(model, groups, here, columns);
  return columns;
}

// One-sided, over a thousandth of each parameter's size.
std::vector<Values> JointsProblem::motor_jacobian(const Model& model,
                                                  const std::vector<Unknown>& unknowns,
                                                  const Groups& groups,
                                                  const Evaluation& here) const {
  constexpr double kStep = 1e-3;
  const ParameterSpace space(model, unknowns);
  std::vector<double> steps;
  for (const Coordinate& c : space) {
    const double z = c.of(model), slope = std::isfinite(c.slope(z)) ? c.slope(z) : 1;
    // Two that act as a product alone must move it alike, or the difference of their differences
    // would pass for what the data know of each: those above 0 by their bounds move by their size.
    steps.push_back(kStep * (c.min > 0 ? std::abs(z) : std::max(c.scale, std::abs(z))) *
                    std::abs(slope));
  }
  return differences(space, model, groups, here, steps, false);
}

// Strength, load and friction may all grow by a tenth and leave the motion as it is but for the
// noise, and two effects may be one by other names. What differences to one side bend by, or to
// other lengths, passes for what the data know of such a direction, and errors would be too small
// by far: near the noise they are those of differences to both sides, over steps that move the
// prediction alike.
void JointsProblem::state_errors(Fit& fit, const std::vector<Unknown>& unknowns,
                                 const Groups& groups) const {
  constexpr double kNear = 3;
  const Evaluation here = evaluate(fit.model, groups, nullptr);
  if (!here.valid || !(misfit_of(*this, here) < kNear)) return;
  std::vector<Unknown> told;
  std::vector<size_t> place;
  for (size_t i = 0; i < unknowns.size(); ++i) {
    const bool spread = fit.model.find(unknowns[i].effect)->definition->spread_only;
    if (spread || !(fit.sigma[i] > 0) || !std::isfinite(fit.sigma[i])) continue;
    // What stays at nothing, where its range ends, leaves what others are known by to them.
    const effects::Parameter& parameter =
        fit.model.find(unknowns[i].effect)->definition->parameters[unknowns[i].parameter];
    const bool at_end = fit.value[i] <= parameter.min || fit.value[i] >= parameter.max;
    if (at_end && fit.value[i] == parameter.neutral) continue;
    told.push_back(unknowns[i]), place.push_back(i);
  }
  if (told.empty()) return;
  const ParameterSpace space(fit.model, told);
  const auto rough = motor_jacobian(fit.model, told, groups, here);
  std::vector<double> steps;
  for (const Values& column : rough)
    steps.push_back(
        1 / std::sqrt(std::inner_product(column.begin(), column.end(), column.begin(), 0.0)));
  const auto columns = differences(space, fit.model, groups, here, steps, true);
  const auto count = static_cast<Eigen::Index>(told.size());
  Eigen::MatrixXd information(count, count);
  for (size_t i = 0; i < told.size(); ++i) {
    for (size_t k = 0; k < told.size(); ++k)
      information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          std::inner_product(columns[i].begin(), columns[i].end(), columns[k].begin(), 0.0);
  }
  if (!information.allFinite()) return;
  const Covariance covariance = covariance_of(information, 1e-13);
  const double misfit2 = std::pow(misfit_of(*this, here), 2);
  for (size_t i = 0; i < told.size(); ++i) {
    for (size_t k = 0; k < told.size(); ++k)
      fit.covariance[place[i] * unknowns.size() + place[k]] =
          misfit2 * covariance.matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
    fit.sigma[place[i]] = covariance.known[i]
                              ? std::sqrt(fit.covariance[place[i] * (unknowns.size() + 1)])
                              : std::numeric_limits<double>::infinity();
  }
}

}  // namespace seam::measurement
