// Bounds of the coordinates in which something is sought.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace seam::measurement {

struct Box {
  Eigen::VectorXd low, high;

  Eigen::VectorXd inside(const Eigen::VectorXd& place) const {
    return place.cwiseMax(low).cwiseMin(high);
  }
  // Coordinates that stand at a bound and are pushed beyond it by a descent along -gradient.
  std::vector<char> held(const Eigen::VectorXd& place, const Eigen::VectorXd& gradient) const {
    std::vector<char> out(static_cast<size_t>(place.size()));
    for (Eigen::Index i = 0; i < place.size(); ++i) {
      out[static_cast<size_t>(i)] =
          (place[i] <= low[i] && gradient[i] > 0) || (place[i] >= high[i] && gradient[i] < 0);
    }
    return out;
  }
};

}  // namespace seam::measurement
