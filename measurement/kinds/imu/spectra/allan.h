// Allan deviation: how far means over tau of neighbouring stretches differ, over the root of two.
#pragma once

#include <functional>
#include <vector>

#include "measurement/problem/curves.h"

namespace seam::measurement {

// By the overlapping estimator, from one sample up to a quarter of the series, two or three times
// an octave; `expected` is left open. Standard errors are those of white noise with as many degrees
// of freedom (Riley, NIST Special Publication 1065, 5.4.1); those of flicker and walks are larger.
std::vector<CurvePoint> allan_deviation(const std::vector<double>& series, double dt_s);

// What noise of this power (stages/inertial.h) gives for means over m samples.
double allan_deviation_of(const std::function<double(double omega)>& power, double m);

}  // namespace seam::measurement
