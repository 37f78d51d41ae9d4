// The motion of a body whose velocity follows a command with a lag: in the body's own frame
//
//   v(t) = to + (from - to) exp(-t / tau)
//
// so that speeds and turning are known at any time, and only the way that they lead over ground is
// an integral without a closed form.
#pragma once

#include <cmath>

#include "sim_core/body/locomotion.h"

namespace seam::effects {

struct FadingVelocity {
  BodyVelocity from, to;
  double tau_s = 0;
  double heading_rad_per_m = 0;  // The body turns so much more for each metre of its path.
};

// Over ground, whatever the body turns.
inline double speed(const BodyVelocity& v) {
  return std::sqrt(v.vx_mps * v.vx_mps + v.vy_mps * v.vy_mps);
}

// Where a body stands and how far it has walked.
struct Place {
  double x_m = 0;
  double y_m = 0;
  double theta_rad = 0;  // Not wrapped.
  double path_m = 0;     // Walked since the start.
};

// Moves for `dt_s` by Gauss's quadrature: within a micrometre and a microradian, and within ten
// where the path's length counts and the body all but stops to turn back.
void move_along(const FadingVelocity& velocity, double dt_s, Place& place);

}  // namespace seam::effects
