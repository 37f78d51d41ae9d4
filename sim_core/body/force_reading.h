// What a robot's accelerometer reads of the force that it feels.
#pragma once

#include <vector>

#include "sim_core/base/pose.h"
#include "sim_core/base/time.h"

namespace seam {

// Called once for each sample, in order. What lasts from one sample to the next (a bias that
// wanders) is in `state`, which belongs to the sensor.
class ForceReading {
 public:
  virtual ~ForceReading() = default;
  // As it is before the first sample; its length stays.
  virtual std::vector<double> first_state() const = 0;
  // Of the sample at `time`. Random parts are drawn at an index that follows from `time`.
  virtual Vec3 reading(const Vec3& force_mps2, SimTime time, std::vector<double>& state) const = 0;
};

}  // namespace seam
