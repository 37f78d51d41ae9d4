// The coordinates in which a model's unknowns are fitted: inside the parameters' bounds, and by the
// reciprocal where the neutral value is infinite (a limit that never binds stands at 0).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/numerics/box.h"
#include "measurement/numerics/curvature.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

struct Coordinate {
  Unknown unknown;
  const effects::Parameter* parameter = nullptr;
  double min = 0, max = 0, scale = 1;  // Of the coordinate.
  bool spread = false;  // Of a noise alone: it has no slope in the residuals, only a likelihood.

  Coordinate(const Model& model, const Unknown& which);

  double to_value(double z) const;
  // d value / d z: 1, or of a reciprocal -value^2 (infinite where the limit never binds).
  double slope(double z) const;
  // Where the model stands, inside the bounds.
  double of(const Model& model) const;
  void set(Model& model, double z) const;
  // At a bound other than the neutral value.
  bool at_bound(double z) const;
};

class ParameterSpace {
 public:
  ParameterSpace(const Model& model, const std::vector<Unknown>& unknowns);

  size_t size() const { return coordinates_.size(); }
  const Coordinate& operator[](size_t i) const { return coordinates_[i]; }
  auto begin() const { return coordinates_.begin(); }
  auto end() const { return coordinates_.end(); }
  const Box& box() const { return box_; }
  bool any_of_mean() const;

  Eigen::VectorXd place(const Model& model) const;
  // Curvatures of a log-likelihood along the coordinates under which data tell nothing of them, or
  // of a sum of several: fits leave these where they stand.
  Eigen::VectorXd untold() const;
  // The model with its unknowns there.
  Model at(Model model, const Eigen::VectorXd& place) const;
  // The model moved by this, as far as the bounds allow.
  Model moved(const Model& model, const Eigen::VectorXd& by) const {
    return at(model, box_.inside(place(model) + by));
  }
  // The same with one coordinate at z.
  Model with(Model model, size_t i, double z) const;

  // An estimate there, its errors not known yet.
  Fit fit_at(const Model& model, const Eigen::VectorXd& place, double log_likelihood,
             bool converged) const;
  // Writes errors of the coordinates, times `misfit`, into those of the parameters.
  void state(const Covariance& covariance, double misfit, const Eigen::VectorXd& place,
             Fit& fit) const;
  // The same for one coordinate that is independent of the others.
  void state(size_t i, double sigma, double z, Fit& fit) const;

 private:
  std::vector<Coordinate> coordinates_;
  Box box_;
};

// A misfit larger than the noise makes estimates less certain in proportion.
double misfit_of(const Problem& problem, const Evaluation& evaluation);

// The error of a spread from the log-likelihood beside it, in its coordinate; `share` of itself is
// the step.
double spread_error(const Problem& problem, const ParameterSpace& space, size_t i,
                    const Model& model, const Groups& groups, const Evaluation* warm, double share);

}  // namespace seam::measurement
