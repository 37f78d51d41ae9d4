#include "tools/workbench/look/climb.h"

namespace seam::tools {

Climbed climb(const std::function<double(const Eigen::VectorXd&)>& height,
              const Eigen::VectorXd& start, Eigen::VectorXd step, const measurement::Box& box,
              int looks) {
  Climbed best{.place = box.inside(start), .height = 0};
  best.height = height(best.place);
  for (int spent = 1; spent < looks && start.size() > 0; ++spent) {
    const Eigen::Index axis = (spent - 1) % start.size();
    Eigen::VectorXd trial = best.place;
    trial[axis] += step[axis];
    trial = box.inside(trial);
    const double there = trial == best.place ? best.height : height(trial);
    if (there > best.height) {
      best = {.place = std::move(trial), .height = there};
      step[axis] *= 2;
    } else {
      step[axis] *= -0.5;
    }
  }
  return best;
}

}  // namespace seam::tools
