// How one joint follows its commands: an exact function of continuous time.
#pragma once

#include <memory>

#include "sim_core/base/random.h"
#include "sim_core/base/time.h"
#include "sim_core/body/state.h"

namespace seam {

// Limits of a joint, from the robot's body file.
struct JointLimits {
  double min_rad = 0;
  double max_rad = 0;
  double speed_radps = 0;
};

// Contract: calls of `command` and `forget_before` come in the order of simulated time; `angle` may
// be asked for any time from the last `forget_before` on, and is the motion that follows from the
// commands given so far (a later command changes only what comes after its own time). Equal calls
// give equal bits.
class JointActuator {
 public:
  virtual ~JointActuator() = default;
  // From `time` on the joint is to go to `target_rad` (already inside the joint's range), no
  // faster than `max_speed_radps`. Commands given earlier for `time` or later are void.
  virtual void command(SimTime time, double target_rad, double max_speed_radps) = 0;
  // Of the load: what moves the camera or the leg.
  virtual double angle(SimTime time) const = 0;
  // What the encoder reads (before the sensor's own noise and rounding).
  virtual double encoder(SimTime time) const { return angle(time); }
  // No earlier time will be asked for any more: history may be dropped.
  virtual void forget_before(SimTime time) = 0;
  virtual void visit(StateVisitor& visitor) = 0;
};

// Goes to its command at the commanded top speed, then rests there.
std::unique_ptr<JointActuator> limited_actuator(double initial_rad);

}  // namespace seam
