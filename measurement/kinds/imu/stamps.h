// What the time stamps of a stretch say of the clock by which the sensor samples.
#pragma once

#include <vector>

#include "measurement/kinds/imu/imu_data.h"

namespace seam::measurement {

// No host reads its clock closer than this: stamps that are even to so much are computed ones.
inline constexpr double kEvenStamps_s = 1e-5;

struct StampPart {
  // How much faster than `rate_hz` samples come, parts per million, and its variance.
  double drift_ppm = 0, drift_variance = 0;
  // Variance of a stamp and the number of values behind it; 0 values: the stamps are even.
  double variance_s2 = 0, freedom = 0;
};

// By parts to which the stretch is dealt out, as its readings are.
std::vector<StampPart> stamps_of(const ImuStretch& stretch, size_t parts, double rate_hz);

}  // namespace seam::measurement
