// Stage `inertial`: what a gyroscope and an accelerometer report of true rates and specific forces,
// and the power of their noise over frequency.
//
// A sensor's mean is
//   measured = clip((I + S + M) true + G force + bias + per_k (T - 25))
// with S its scale errors, M its misalignments, G the gyroscope's sensitivity to force. Its noise
// is the power of a coefficient of the orthonormal cosine transform (DCT-II) of samples dt
// apart, at omega = 2 pi f dt:
//   white^2 / dt + flicker^2 / (2 sin(omega / 2)) + walk^2 dt / (2 sin(omega / 2))^2
//   + rounding^2 (2 sin(omega / 2))^2 / dt^2 + lines of vibrations (vibration.h)
// In this transform white noise and a random walk are independent exactly, coefficient by
// coefficient: its base are the eigenvectors of a walk's precision (docs/reference/imu.md). Letters
// and sizes are those of IEEE Std 952: N, B, K, Q.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/stages/noise.h"
#include "sim_core/base/pose.h"

namespace seam::effects {

// Their stage and their kind of measurement, beyond those that kind.h lists.
inline constexpr Stage kInertial{12};
inline constexpr Kind kImu{256};

Inertial inertial_of(const Model& model);

struct InertialSample {
  Vec3 rate_radps{0.0};
  Vec3 force_mps2{0.0};  // Specific force: at rest it points up, with the size of gravity.
};
InertialSample measured_by(const Inertial& inertial, const InertialSample& truth,
                           double temperature_c);

// R_IC, which gives vectors in a camera's axes (x right, y down, z forward) in those of the sensor.
Mat3 camera_axes(const Inertial& inertial);

// See above; omega above 0 and up to pi. The first without vibrations, whose lines are narrow.
double smooth_noise_power(const InertialSensor& sensor, size_t axis, double omega, double dt_s);
double noise_power(const InertialSensor& sensor, size_t axis, double omega, double dt_s);

// Three parameters, one an axis: x_NAME, y_NAME, z_NAME.
std::vector<Parameter> axis_parameters(const std::string& unit_name, double least, double most,
                                       double usual, const std::string& help,
                                       const Plausible& plausible = {});
// One a pair: xy_rad is what axis x has of axis y.
std::vector<Parameter> cross_parameters(const std::vector<std::string>& pairs);
// Starts of a fit: the same size on all axes, in steps of half a decade.
std::vector<StartRule> noise_starts(double from, double to);
// Of a vibration (`usual`: what can just be seen, since steps of fits from an axis without a line
// are as long): its sizes by axis, its frequency, its quality, its skew; in this order wherever
// fits start with StartSearch::frequency.
std::vector<Parameter> vibration_parameters(const std::string& unit_name, double most, double usual,
                                            const std::string& help, const Plausible& plausible);
inline Vibration vibration(Values p) {
  return {.rms = {p[0], p[1], p[2]}, .frequency_hz = p[3], .width_hz = p[3] / p[4], .skew = p[5]};
}

inline Triad triad(Values p) {
  return {p[0], p[1], p[2]};
}
inline void add_to(Triad& sum, Values p) {
  for (size_t axis = 0; axis < 3; ++axis) sum[axis] += p[axis];
}
// Independent errors: squares add up.
void add_noise(Triad& sum, Values p);

}  // namespace seam::effects
