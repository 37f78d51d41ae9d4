// Maximum of a smooth log-likelihood of a few parameters inside bounds: Newton's method with
// derivatives from differences whose steps adapt to half a standard deviation, damped as
// Levenberg and Marquardt do. Gives the covariance from the curvature at the maximum.
#pragma once

#include <functional>
#include <vector>

namespace seam::measurement {

struct SearchParameter {
  double start = 0;
  double min = 0;
  double max = 0;
  double step = 0.01;        // First step of the differences (relative for logarithmic ones).
  bool logarithmic = false;  // Sought on a logarithmic scale (positive).
  bool step_fits = false;    // The step is half a standard deviation, and the start near the end.
};

struct Maximum {
  std::vector<double> value;
  std::vector<double> sigma;  // Infinite where the function does not depend on it.
  // The same by differences along the axes alone: beyond reason where a valley is long and bent.
  std::vector<double> axis_sigma;
  std::vector<double> step;  // Half a standard deviation along each axis, as SearchParameter::step.
  std::vector<double> covariance;  // Row-major.
  std::vector<char> at_bound;
  // Of minus the log-likelihood, row-major, on the search's scale.
  std::vector<double> curvature;
  double log_likelihood = 0;
  double gained = 0;  // On the start's.
  bool converged = false;
};

enum class Calls { one_by_one, side_by_side };

// With `Calls::side_by_side` values for differences are asked for on several threads at once; the
// answer is the same. `alike`: a curvature with the correlations that this one has (a maximum's, of
// part of the data); they are then measured only where steps gain less than they promise.
Maximum maximise(const std::function<double(const std::vector<double>&)>& log_likelihood,
                 const std::vector<SearchParameter>& parameters, Calls calls = Calls::one_by_one,
                 const std::vector<double>& alike = {});

}  // namespace seam::measurement
