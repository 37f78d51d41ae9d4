#include "measurement/kinds/photometry/structure/photometry_chi2.h"

#include <cmath>

#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

std::pair<double, int> chi2_of(const Eigen::VectorXd& t, const Eigen::MatrixXd& c,
                               const Eigen::VectorXd& reference) {
  Eigen::VectorXd scale(t.size());
  for (Eigen::Index i = 0; i < t.size(); ++i)
    scale[i] = reference[i] > 0 ? 1 / std::sqrt(reference[i]) : 0;
  const Eigen::MatrixXd unit = scale.asDiagonal() * c * scale.asDiagonal();
  const Eigen::VectorXd s = scale.cwiseProduct(t);
  const SymmetricEigen eigen = symmetric_eigen(unit);
  double chi2 = 0;
  int freedom = 0;
  for (Eigen::Index i = 0; i < t.size(); ++i) {
    // Directions that the parameters have absorbed are rounding.
    if (eigen.values[i] < 1e-6) continue;
    const double along = eigen.vectors.col(i).dot(s);
    chi2 += along * along / eigen.values[i];
    ++freedom;
  }
  return {chi2, freedom};
}

}  // namespace seam::measurement
