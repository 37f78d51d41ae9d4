// A set of kind `imu` as it is read: stretches of even samples at one attitude and one rate.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/gyro/gyroscope.h"
#include "measurement/problem/problem.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

inline constexpr std::array<const char*, kImuAxes> kImuTruth = {"wx_true_radps", "wy_true_radps",
                                                                "wz_true_radps", "ax_true_mps2",
                                                                "ay_true_mps2",  "az_true_mps2"};

struct ImuStretch {
  std::string group;  // Its run, or its own number where the set names none.
  double dt_s = 0;
  double start_s = 0;                                 // Since the first sample of the set.
  std::vector<size_t> rows;                           // Of the table.
  std::vector<double> stamp_s;                        // Of each, since its own first one.
  std::array<std::vector<double>, kImuAxes> samples;  // Empty: not measured, or a protocol.
  std::array<double, kImuAxes> truth{};               // Where it is known.
  std::vector<double> temperature_c;                  // Empty: not logged.
  std::array<double, kImuAxes> mean{};                // Of the samples.
  std::optional<double> warmth_c;                     // The mean temperature.
};

// The mean that its accelerometer reads.
Vec3 force_read(const ImuStretch& stretch);
double size_of(const Vec3& v);

struct ImuData {
  std::vector<ImuStretch> stretches;
  std::array<bool, kImuAxes> has{};  // Whether the axis was measured.
  bool knows_rates = false;          // Else the gyroscope is at rest.
  bool knows_forces = false;         // Else only the size of gravity is known.
  double gravity_mps2 = 9.80665;
  double rate_hz = 0;  // By the sensor's own clock; 0: not known.
  size_t left = 0;     // Samples that are in no stretch.
};

// Throws InputError for a model with an effect that does not act on inertial sensors.
void expect_inertial(const Problem& problem, const Model& model);

// Reads and checks imu.csv. `measured` false: a protocol, readings are not looked at.
ImuData read_imu(const MeasurementSet& set, bool measured);

}  // namespace seam::measurement
