// A good place of a function that is dear, after so few looks that a person need not wait: uphill
// along each axis in turn, with steps that grow while they help and turn back where they do not.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "measurement/numerics/box.h"

namespace seam::tools {

struct Climbed {
  Eigen::VectorXd place;
  double height = 0;
};

// `step`: how far it looks first, by axis. Not higher than the start where nothing is.
Climbed climb(const std::function<double(const Eigen::VectorXd&)>& height,
              const Eigen::VectorXd& start, Eigen::VectorXd step, const measurement::Box& box,
              int looks);

}  // namespace seam::tools
