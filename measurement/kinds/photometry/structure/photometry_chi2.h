// What the tests of structure in the residuals of a photometry set share.
#pragma once

#include <Eigen/Core>
#include <utility>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// A structure that may be there, with the chi-square that says so.
struct StructureTest {
  Structure structure;
  double chi2 = 0;
  int freedom = 0;
};

// The chi-square of statistics T with covariance C and its degrees of freedom, in the directions in
// which C has any size beside `reference`, its diagonal before parameters absorbed parts of it.
std::pair<double, int> chi2_of(const Eigen::VectorXd& t, const Eigen::MatrixXd& c,
                               const Eigen::VectorXd& reference);

}  // namespace seam::measurement
