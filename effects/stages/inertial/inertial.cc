#include "effects/stages/inertial/inertial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_core/base/maths.h"

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

double noise_power(const InertialSensor& sensor, size_t axis, double omega, double dt_s) {
  const double difference = 2 * maths::sin(omega / 2);
  const auto square = [](double x) { return x * x; };
  return square(sensor.white[axis]) / dt_s + square(sensor.flicker[axis]) / difference +
         square(sensor.walk[axis] / difference) * dt_s +
         square(sensor.rounding[axis] * difference / dt_s);
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

void add_noise(Triad& sum, Values p) {
  for (size_t axis = 0; axis < 3; ++axis)
    if (p[axis] > 0) sum[axis] = std::hypot(sum[axis], p[axis]);
}

}  // namespace seam::effects
