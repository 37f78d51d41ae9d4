#include "measurement/gyro/read_turns.h"

namespace seam::measurement {

ReadTurns::ReadTurns(const GyroscopeBeside& beside, const effects::Model& model)
    : inertial_(effects::inertial_of(model)),
      path_(beside.readings, inertial_),
      first_s_(beside.first_s),
      R_IC_(effects::camera_axes(inertial_)) {}

double ReadTurns::sensor_s(double at_s, double exposure_s) const {
  return at_s - first_s_ + offset_at(inertial_, exposure_s);
}

Mat3 ReadTurns::between(double from_s, double to_s, double exposure_s) const {
  const Mat3 R_0I = path_.attitude(sensor_s(from_s, exposure_s)),
             R_I0 = glm::transpose(path_.attitude(sensor_s(to_s, exposure_s)));
  return glm::transpose(R_IC_) * R_I0 * R_0I * R_IC_;
}

Vec3 ReadTurns::rate(double at_s, double exposure_s) const {
  return -(glm::transpose(R_IC_) * path_.rate(sensor_s(at_s, exposure_s)));
}

}  // namespace seam::measurement
