#include "effects/stages/inertial/inertial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "effects/stages/inertial/vibration.h"
#include "sim_core/base/maths.h"
#include "sim_core/body/turn.h"

namespace seam::effects {
namespace {

Vec3 reported(const InertialSensor& sensor, const Vec3& truth, const Vec3& beside,
              double temperature_c) {
  Vec3 out(0.0);
  const double warmer = temperature_c - kBiasAt_c;
  for (int axis = 0; axis < 3; ++axis) {
    double value = (1 + sensor.scale[axis]) * truth[axis] + beside[axis] + sensor.bias[axis] +
                   sensor.per_k[axis] * warmer;
    for (int other = 0; other < 3; ++other) value += sensor.cross[axis][other] * truth[other];
    out[axis] = std::clamp(value, -sensor.most, sensor.most);
  }
  return out;
}

}  // namespace

Inertial inertial_of(const Model& model) {
  return noise_of(model).inertial;
}

InertialSample measured_by(const Inertial& inertial, const InertialSample& truth,
                           double temperature_c) {
  Vec3 of_force(0.0);
  for (int axis = 0; axis < 3; ++axis)
    of_force[axis] = inertial.gyro_per_force[axis] * truth.force_mps2[axis];
  return {reported(inertial.gyro, truth.rate_radps, of_force, temperature_c),
          reported(inertial.accel, truth.force_mps2, Vec3(0.0), temperature_c)};
}

Mat3 camera_axes(const Inertial& inertial) {
  const auto& [x, y, z] = inertial.camera_turn_rad;
  return rotation_by(Vec3(x, y, z));
}

double smooth_noise_power(const InertialSensor& sensor, size_t axis, double omega, double dt_s) {
  const double difference = 2 * maths::sin(omega / 2);
  const auto square = [](double x) { return x * x; };
  return square(sensor.white[axis]) / dt_s + square(sensor.flicker[axis]) / difference +
         square(sensor.walk[axis] / difference) * dt_s +
         square(sensor.rounding[axis] * difference / dt_s);
}

double noise_power(const InertialSensor& sensor, size_t axis, double omega, double dt_s) {
  double power = smooth_noise_power(sensor, axis, omega, dt_s);
  for (const Vibration& one : sensor.vibrations) power += vibration_power(one, axis, omega, dt_s);
  return power;
}

std::vector<Parameter> axis_parameters(const std::string& unit_name, double least, double most,
                                       double usual, const std::string& help,
                                       const Plausible& plausible) {
  std::vector<Parameter> parameters;
  for (const char* axis : {"x", "y", "z"}) {
    parameters.push_back({.name = std::string(axis) + "_" + unit_name,
                          .min = least,
                          .max = most,
                          .scale = usual,
                          .help = "Axis " + std::string(axis) + ": " + help,
                          .plausible = plausible});
  }
  return parameters;
}

std::vector<Parameter> cross_parameters(const std::vector<std::string>& pairs) {
  std::vector<Parameter> parameters;
  for (const std::string& pair : pairs) {
    parameters.push_back(
        {.name = pair + "_rad",
         .min = -0.5,
         .max = 0.5,
         .scale = 0.005,
         .help = fmt::format("What axis {} has of axis {}, radians.", pair[0], pair[1])});
  }
  return parameters;
}

std::vector<StartRule> noise_starts(double from, double to) {
  std::vector<std::vector<double>> places;
  for (double size = from; size <= to; size *= std::sqrt(10.0))
    places.push_back({size, size, size});
  return {{kImu, StartSearch::best_listed, std::move(places)}};
}

std::vector<Parameter> vibration_parameters(const std::string& unit_name, double most, double usual,
                                            const std::string& help, const Plausible& plausible) {
  std::vector<Parameter> parameters = axis_parameters(unit_name, 0, most, usual, help, plausible);
  parameters.push_back({.name = "frequency_hz",
                        .neutral = 50,
                        .min = 1e-3,
                        .max = 1e5,
                        .scale = 1,
                        .help = "Frequency of the line, Hz. A line above half of the rate of the "
                                "samples is seen mirrored below it.",
                        .plausible = {0.5, 5000,
                                      "motors turn 10 to 500 times a second, and blades "
                                      "and gears repeat that some ten times"}});
  parameters.push_back({.name = "quality",
                        .neutral = kNever,
                        .min = 1,
                        .max = kNever,
                        .scale = 50,
                        .help = "Frequency over width, where the width is that of the line's power "
                                "at half of its height; without end: a sine.",
                        .fit_reciprocal = true,
                        .plausible = {3, kNever,
                                      "rubber and plastic damp to 5 to 20, metal to "
                                      "100 and more"}});
  parameters.push_back({.name = "skew",
                        .min = -4,
                        .max = 2,
                        .scale = 0.3,
                        .help =
                            "0: a sine whose phase wanders, as a motor's. Of an oscillator that "
                            "noise drives: 1 its deflection, with more power below the line, "
                            "-1 its rate, -3 its acceleration, with more above.",
                        .on_demand = true,
                        .plausible = {-3.5, 1.5, "an oscillator has -3 to 1"}});
  return parameters;
}

void add_noise(Triad& sum, Values p) {
  for (size_t axis = 0; axis < 3; ++axis)
    if (p[axis] > 0) sum[axis] = std::hypot(sum[axis], p[axis]);
}

}  // namespace seam::effects
