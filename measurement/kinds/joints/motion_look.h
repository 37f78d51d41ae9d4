// A coarse look for the parameters of an equation of motion: which values agree best with the
// accelerations that the logs show. Whole runs have many valleys, accelerations nearly none, so
// that this finds the valley in which a fit of whole runs begins.
#pragma once

#include <vector>

#include "measurement/kinds/joints/joints.h"

namespace seam::measurement {

class MotionLook {
 public:
  // Of the logs whose flag is set.
  MotionLook(const JointLogs& set, const std::vector<char>& chosen, double noise_rad);

  // What the model misses, comparable between models: in the unit of the data.
  double cost(const Model& model) const;
  // Descends from `model` in these parameters. Returns the cost; infinite where nothing moves.
  double descend(Model& model, const std::vector<Unknown>& unknowns) const;

 private:
  // A place of a log with what is seen of the motion there.
  struct Instant {
    const JointLog* log;
    size_t row, reach;  // The acceleration is seen from so many rows before to as many after.
    size_t pieces;      // Into which that time is cut.
    double q_rad, w_radps, a_radps2;
    double reach_s;     // The same as time, on the mean of both sides.
    double rest_radps;  // Slower counts as at rest.
  };

  void add_instants(const JointLog& log, size_t stride, size_t reach, double noise_rad);
  std::vector<double> misses(const Model& model) const;

  std::vector<Instant> instants_;
};

}  // namespace seam::measurement
