// Readings of a gyroscope beside a camera, and how the body turned by them.
#pragma once

#include <array>
#include <vector>

#include "effects/stages/inertial/inertial.h"
#include "measurement/sets/set.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

// Axes are numbered: the gyroscope's x, y, z, then the accelerometer's.
inline constexpr size_t kImuAxes = 6;
inline constexpr std::array<const char*, kImuAxes> kImuColumns = {
    "wx_radps", "wy_radps", "wz_radps", "ax_mps2", "ay_mps2", "az_mps2"};

// What a spectrum takes at least.
inline constexpr size_t kLeastSamples = 64;

struct Gyroscope {
  std::vector<double> at_s;  // Since its first sample.
  std::vector<Vec3> rate_radps;
  std::vector<double> temperature_c;  // Empty: not logged.
};

// On the body of a camera.
struct GyroscopeBeside {
  Gyroscope readings;
  double first_s = 0;  // Its first sample, by the clock of the frames.
};

// What the effect alone does at a typical size of one parameter, all others at neutral.
effects::Inertial tried_alone(const effects::EffectDefinition& effect, size_t parameter);
// Time of the sensor less that of the camera, of a view of this exposure.
inline double offset_at(const effects::Inertial& by, double exposure_s) {
  return by.camera_offset_s + by.camera_offset_of_exposure * exposure_s;
}
// Whether the effect, or a model, says where the sensor is beside a camera.
bool is_of_camera(const effects::Inertial& by);
// Whether rates that such a sensor reads are others than the true ones in the mean.
bool moves_rates(const effects::InertialSensor& gyro);

// Throws InputError for a row of a table that is not later than the row before.
void expect_later(const CsvTable& table, const std::vector<int64_t>& time_ns, size_t row);

// The table `imu`; `first_ns` becomes the time of its first sample.
Gyroscope read_gyroscope(const MeasurementSet& set, int64_t& first_ns);

// The usual time from sample to sample.
double usual_step_s(const Gyroscope& gyroscope);
// Whether it reads without a gap from one time to the other.
bool reads_all(const Gyroscope& gyroscope, double usual_s, double from_s, double to_s);

// How the sensor turned, by its readings and by what a model says is wrong with them.
class GyroPath {
 public:
  // Refers to the readings.
  GyroPath(const Gyroscope& gyroscope, const effects::Inertial& inertial);

  // From one time to another, in the sensor's axes at the first.
  Vec3 turn(double from_s, double to_s) const;
  // Vectors in the sensor's axes at a time, in those at its first sample.
  Mat3 attitude(double at_s) const;
  // The true rate at a time; before the first sample and behind the last theirs.
  Vec3 rate(double at_s) const;

 private:
  size_t before(double at_s) const;

  const Gyroscope* gyroscope_;
  std::vector<Vec3> rate_;  // What was true, at each sample.
  std::vector<Mat3> R_0I_;  // The sensor's axes then in those at the first sample.
};

}  // namespace seam::measurement
