// A parameter's neutral value, and the error that a plan states of it.
#pragma once

#include "measurement/fitting/parameter_space.h"

namespace seam::measurement {

inline double neutral_of(const Coordinate& c) {
  return c.parameter->fit_reciprocal ? 0 : c.parameter->neutral;
}

// The standard error of a value, from that of its coordinate, with what its resolution adds.
double error_of_value(const Coordinate& coordinate, double slope, double error);

}  // namespace seam::measurement
