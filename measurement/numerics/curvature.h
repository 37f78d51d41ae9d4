// From the curvature of a log-likelihood at its maximum to errors of the estimates.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace seam::measurement {

struct Covariance {
  Eigen::MatrixXd matrix;   // Zero in the rows and columns of what is not known.
  std::vector<char> known;  // Whether the data say anything of a coordinate.
};

// The inverse of an information matrix (J'J, or minus second derivatives), scaled to a unit
// diagonal. A combination of coordinates with less than `floor` of the information that each has
// alone counts as having so much: its error becomes large, not infinite.
Covariance covariance_of(const Eigen::MatrixXd& information, double floor);

// The error of a noise's sigma from the second difference of minus the log-likelihood over the
// step h; infinite where there is no minimum. The likelihood knows only the square of a sigma, so
// that it is mirrored at zero.
double sigma_of_spread(const std::function<double(double)>& minus_log_likelihood, double sigma,
                       double h);

}  // namespace seam::measurement
