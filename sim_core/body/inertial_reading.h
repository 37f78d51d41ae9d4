// What a robot's accelerometer or gyroscope reads of how its body moves.
#pragma once

#include <vector>

#include "sim_core/base/pose.h"
#include "sim_core/base/time.h"

namespace seam {

// Of the body, in its frame.
struct BodyMotion {
  Vec3 rate_radps{0.0};
  Vec3 force_mps2{0.0};  // Specific force: +9.81 in z at rest.
};

// Called once for each sample, in order. What lasts from one sample to the next (a bias that
// wanders) is in `state`, which belongs to the sensor.
class InertialReading {
 public:
  virtual ~InertialReading() = default;
  // As it is before the first sample; its length stays.
  virtual std::vector<double> first_state() const = 0;
  // Of the sample at `time`. Random parts are drawn at an index that follows from `time`.
  virtual Vec3 reading(const BodyMotion& motion, SimTime time,
                       std::vector<double>& state) const = 0;
};

}  // namespace seam
