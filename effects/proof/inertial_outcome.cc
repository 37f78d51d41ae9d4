#include "effects/proof/inertial_outcome.h"

#include "effects/stages/inertial/inertial.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

Quantities inertial_outcome(const Model& model, const Quantities& given) {
  const auto vector = [&](const std::string& letter, const std::string& unit) {
    return Vec3(value_of(given, letter + "x_" + unit), value_of(given, letter + "y_" + unit),
                value_of(given, letter + "z_" + unit));
  };
  const Inertial inertial = inertial_of(model);
  const InertialSample seen = measured_by(inertial, {vector("w", "radps"), vector("a", "mps2")},
                                          value_of(given, "temperature_c", kBiasAt_c));
  const double dt_s = 1 / value_of(given, "rate_hz", 100);
  const double omega = 2 * maths::kPi * value_of(given, "frequency_hz", 1) * dt_s;
  Quantities out;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name(1, "xyz"[axis]);
    const auto index = static_cast<size_t>(axis);
    out.push_back({"w" + name + "_radps", seen.rate_radps[axis]});
    out.push_back({"a" + name + "_mps2", seen.force_mps2[axis]});
    out.push_back({"w" + name + "_power", noise_power(inertial.gyro, index, omega, dt_s)});
    out.push_back({"a" + name + "_power", noise_power(inertial.accel, index, omega, dt_s)});
  }
  out.push_back({"sample_distance_s", dt_s / (1 + 1e-6 * inertial.clock_ppm)});
  out.push_back({"stamp_sigma_s", inertial.stamp_sigma_s});
  out.push_back({"camera_offset_s", inertial.camera_offset_s + inertial.camera_offset_of_exposure *
                                                                   value_of(given, "exposure_s")});
  const Vec3 turned = camera_axes(inertial) * Vec3(value_of(given, "wx_camera_radps"),
                                                   value_of(given, "wy_camera_radps"),
                                                   value_of(given, "wz_camera_radps"));
  for (int axis = 0; axis < 3; ++axis)
    out.push_back({std::string("w") + "xyz"[axis] + "_turned_radps", turned[axis]});
  return out;
}

}  // namespace seam::effects
