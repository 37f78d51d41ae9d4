// Fits of an equation of motion over short stretches of the logs, each of which begins where the
// joint was seen to be, and as fast. Over a whole run a small wrong stiffness or friction ends in
// another phase of a swing, so that whole runs have many valleys; short ones have few, and their
// bottom is where a fit of whole runs should begin.
#pragma once

#include <vector>

#include "measurement/kinds/joints/joints.h"

namespace seam::measurement {

class ShortRuns {
 public:
  // Of the logs whose flag is set, cut into stretches of about `length_s`.
  ShortRuns(const JointLogs& set, const std::vector<char>& chosen, double length_s);

  // Descends from `model` in these parameters; returns where it ends.
  Model descend(Model model, const std::vector<Unknown>& unknowns) const;

  // Sum of squares; infinite where a prediction is no number.
  double cost(const Model& model) const;
  // Measured less predicted, of all rows.
  std::vector<double> misses(const Model& model) const;

 private:
  void cut(const JointLog& log, double length_s);

  const JointLogs& set_;
  std::vector<JointLog> stretches_;
  size_t rows_ = 0;
};

}  // namespace seam::measurement
