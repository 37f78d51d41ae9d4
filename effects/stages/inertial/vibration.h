// A vibration in the readings of an inertial sensor: a line of noise about one frequency, as a
// resonance of the mount that noise drives or a motor that turns almost evenly makes it.
//
// Its autocovariance is
//   rms^2 exp(-pi width |lag|) (cos(2 pi f lag) + skew width / (2 f) sin(2 pi f |lag|))
// Skew 0 is a sine whose phase wanders, a Lorentzian over frequency. Of an oscillator that white
// noise drives, skew 1 is the deflection, with more power below f than above, -1 the rate, and near
// f -3 the acceleration: far from f such a formula would take power away, which counts as none. f
// is the frequency at which it swings when it is left alone. Samples dt apart fold the power at
// half of their rate. Folding included it is, at omega = 2 pi f dt,
//   rms^2 / 2 (P(omega - turn) + P(omega + turn)
//              + skew width / (2 f) (C(turn + omega) + C(turn - omega)))
//   P(x) = (1 - q^2) / D(x),  C(x) = 2 q sin x / D(x),  D(x) = 1 - 2 q cos x + q^2
// with q = exp(-pi width dt) and turn = 2 pi frequency dt: Poisson's kernel, whose mean is 1, and
// its conjugate.
#pragma once

#include <cstddef>

#include "effects/stages/noise.h"

namespace seam::effects {

double vibration_power(const Vibration& line, size_t axis, double omega, double dt_s);

// The mean power of the lines of a cosine transform from omega `from` to `to`, of `samples`
// samples: they widen what is narrower than about 1 / their duration.
double vibration_power_between(const Vibration& line, size_t axis, double from, double to,
                               double samples, double dt_s);

// Allan variance of means over `m` samples.
double vibration_allan_variance(const Vibration& line, size_t axis, double m, double dt_s);

}  // namespace seam::effects
