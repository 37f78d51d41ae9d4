#include "measurement/numerics/curvature.h"

#include <cmath>
#include <limits>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Covariance covariance_of(const MatrixXd& information, double floor) {
  const Index count = information.rows();
  Covariance out{MatrixXd::Zero(count, count), std::vector<char>(static_cast<size_t>(count), 0)};
  std::vector<Index> known;
  for (Index i = 0; i < count; ++i) {
    if (!(information(i, i) > 0)) continue;
    out.known[static_cast<size_t>(i)] = 1;
    known.push_back(i);
  }
  const VectorXd scale = information.diagonal()(known).cwiseSqrt().cwiseInverse();
  const MatrixXd unit = scale.asDiagonal() * information(known, known) * scale.asDiagonal();
  out.matrix(known, known) = scale.asDiagonal() * floored_inverse(unit, floor) * scale.asDiagonal();
  return out;
}

double sigma_of_spread(const std::function<double(double)>& minus_log_likelihood, double sigma,
                       double h) {
  const double curvature = (minus_log_likelihood(sigma + h) - 2 * minus_log_likelihood(sigma) +
                            minus_log_likelihood(std::abs(sigma - h))) /
                           (h * h);
  return curvature > 0 ? 1 / std::sqrt(curvature) : std::numeric_limits<double>::infinity();
}

}  // namespace seam::measurement
