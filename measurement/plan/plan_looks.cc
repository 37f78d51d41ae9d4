// Planned effects one by one: what a set says of each at a size.
#include <cmath>
#include <limits>

#include "measurement/judge/decisions.h"
#include "measurement/judge/evidence.h"
#include "measurement/plan/likelihood_look.h"
#include "measurement/plan/plan.h"
#include "measurement/plan/planned_value.h"

namespace seam::measurement {

double error_of_value(const Coordinate& coordinate, double slope, double error) {
  const double resolution = coordinate.parameter->resolution;
  const double sigma = std::abs(slope) * error;
  return std::isfinite(sigma) ? std::sqrt(sigma * sigma + resolution * resolution / 12)
                              : std::numeric_limits<double>::infinity();
}

double Planner::slope_at(const Coordinate& coordinate, double z) const {
  return coordinate.slope(z) * (by_likelihood_ ? quadratic_slope(coordinate, z) : 1);
}

EffectLook Planner::look_at_truth(const Seen& seen, const Model& truth, size_t k,
                                  double away) const {
  Eigen::VectorXd way = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(seen.unknowns.size()));
  way[static_cast<Eigen::Index>(k)] = to_quadratic(Coordinate(truth, seen.unknowns[k]), away);
  return look_by_likelihood(*options_.made(truth), truth, seen.unknowns, way, base_columns(seen));
}

double Planner::price_of(const Seen& seen, const Model& truth, const EffectLook& look) const {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(seen.unknowns.size()));
  const std::vector<double> errors = standard_errors(look);
  double price = kOdds + std::log(looks_ * problem_.looks(base_.assessment.model, *seen.effect));
  for (size_t k = 0; k < seen.unknowns.size(); ++k) {
    const Coordinate coordinate(truth, seen.unknowns[k]);
    const double z = coordinate.of(truth), value = coordinate.to_value(z);
    const double slope = std::abs(slope_at(coordinate, z));
    sizes[static_cast<Eigen::Index>(k)] =
        prior_size(*coordinate.parameter, value, slope * errors[k]) / slope;
    if (seen.unknowns[k].effect != seen.effect->name) continue;
    const double away = distance_in_sizes(*coordinate.parameter, value);
    price += std::log1p(away * away);
  }
  const auto base = static_cast<Eigen::Index>(look.base);
  const Eigen::MatrixXd& information = look.fitted().information;
  return price - occam_factor(information, sizes) +
         occam_factor(information.topLeftCorner(base, base), sizes.head(base));
}

std::optional<Planner::Moved> Planner::moved(const Seen& seen, size_t parameter,
                                             double away) const {
  const std::string& name = seen.effect->name;
  Model truth = base_.assessment.model;
  truth.add_neutral(seen.effect);
  const Coordinate coordinate(truth, {name, parameter});
  const double z = neutral_of(coordinate) + away;
  coordinate.set(truth, z);
  const size_t k = *index_of(seen.unknowns, {name, parameter});
  Moved out;
  if (by_likelihood_) {
    out.look = look_at_truth(seen, truth, k, away);
  } else {
    const Evaluation there = problem_.evaluate(truth, problem_.all_groups(), &here_);
    if (!there.valid) return std::nullopt;
    std::string why;
    const Columns columns = columns_of(seen, truth, there, why);
    if (!why.empty()) return std::nullopt;
    const bool spread = seen.effect->spread_only;
    out.shift = spread ? spread_shift_of(here_, there) : shift_of(here_, there);
    out.look = look_of(problem_, there, columns, out.shift, base_columns(seen), repeats_);
    // What counts of a spread is the share by which standard deviations change.
    for (auto& movement : out.look.movement) movement *= spread ? 0.5 : 1;
  }
  out.look.price = price_of(seen, truth, out.look);
  out.look.material = options_.material;
  out.sigma = error_of_value(coordinate, slope_at(coordinate, z), standard_errors(out.look)[k]);
  return out;
}

EffectLook Planner::look_at_model() const {
  const Model& model = base_.assessment.model;
  const std::vector<Unknown>& unknowns = base_.assessment.unknowns;
  if (by_likelihood_) {
    const auto count = static_cast<Eigen::Index>(unknowns.size());
    return look_by_likelihood(problem_, model, unknowns, Eigen::VectorXd::Zero(count),
                              unknowns.size());
  }
  const Columns columns = columns_at(problem_, model, unknowns, here_);
  const std::vector<double> none(here_.whitened.size(), 0);
  return look_of(problem_, here_, columns, none, unknowns.size(), repeats_);
}

PlannedEffect Planner::of_model(const std::string& effect) const {
  PlannedEffect out{.effect = effect, .in_model = true};
  const Model& model = base_.assessment.model;
  const std::vector<Unknown>& unknowns = base_.assessment.unknowns;
  const EffectLook look = look_at_model();
  const std::vector<double> errors = standard_errors(look);
  for (size_t k = 0; k < unknowns.size(); ++k) {
    if (unknowns[k].effect != effect) continue;
    const Coordinate coordinate(model, unknowns[k]);
    const double slope = slope_at(coordinate, coordinate.of(model));
    out.parameters.push_back({.name = coordinate.parameter->name,
                              .sigma = error_of_value(coordinate, slope, errors[k])});
  }
  return out;
}

}  // namespace seam::measurement
