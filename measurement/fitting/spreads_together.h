// Fits the spreads of effects that have several: a wander's size and memory lie along a narrow
// valley, down which no walk along one of them at a time leads.
#pragma once

#include <vector>

#include "measurement/fitting/parameter_space.h"

namespace seam::measurement {

struct SpreadsTogether {
  std::vector<size_t> which;       // Coordinates that were fitted; empty: no effect has several.
  Eigen::VectorXd place;           // Of all coordinates.
  std::vector<double> covariance;  // Of those that were fitted, row-major.
  double log_likelihood = 0;

  bool has(size_t coordinate) const;
  // Whether a model as likely as this is still the one that was found.
  bool holds_at(double likelihood) const;
  // Writes their errors into a fit.
  void state(Fit& fit) const;
};

// From where the model stands, by Newton in the logarithms. Spreads that stand at nothing stay.
// `before`: what was found when other parameters were a little off; it tells how far to look.
SpreadsTogether fit_spreads_together(const Problem& problem, const ParameterSpace& space,
                                     const Model& model, const Groups& groups,
                                     const Evaluation* warm,
                                     const SpreadsTogether* before = nullptr);

}  // namespace seam::measurement
