#include "measurement/noise/low_rank.h"

#include <Eigen/Core>
#include <cmath>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

void whiten_low_rank(const std::vector<size_t>& scalars, const Eigen::MatrixXd& causes, int group,
                     Evaluation& evaluation) {
  const size_t n = scalars.size();
  Eigen::MatrixXd scaled = causes;
  Eigen::VectorXd z(n);
  for (size_t k = 0; k < n; ++k) {
    scaled.row(k) /= evaluation.sigma[scalars[k]];
    z[k] = evaluation.whitened[scalars[k]];
  }
  // With U~ = D^-1/2 U and U~' U~ = V L V': (1 + U~ U~')^-1/2 = 1 - W (1 - (1 + L)^-1/2) W',
  // W = U~ V L^-1/2 orthonormal.
  const SymmetricEigen eigen = symmetric_eigen(scaled.transpose() * scaled);
  for (Eigen::Index c = 0; c < eigen.values.size(); ++c) {
    const double l = eigen.values[c];
    if (!(l > 1e-12)) continue;
    const Eigen::VectorXd w = scaled * eigen.vectors.col(c) / std::sqrt(l);
    z -= w * ((1 - 1 / std::sqrt(1 + l)) * w.dot(z));
    evaluation.log_det[group] += std::log1p(l);
  }
  for (size_t k = 0; k < n; ++k) {
    evaluation.whitened[scalars[k]] = z[k];
    evaluation.sigma[scalars[k]] = std::sqrt(
        evaluation.sigma[scalars[k]] * evaluation.sigma[scalars[k]] + causes.row(k).squaredNorm());
  }
}

}  // namespace seam::measurement
