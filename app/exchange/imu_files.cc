#include "app/exchange/imu_files.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "app/exchange/servo_files.h"
#include "effects/stages/inertial/inertial.h"
#include "effects/stages/inertial/vibration.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::app {
namespace {

using effects::InertialSensor;
using effects::Model;
using effects::ModelEffect;

double most(const effects::Triad& values) {
  return *std::max_element(values.begin(), values.end());
}

// Whether the file loses noise of it.
bool has_other_noise(const InertialSensor& sensor) {
  return most(sensor.flicker) > 0 || most(sensor.rounding) > 0 || !sensor.vibrations.empty();
}
bool has_noise(const InertialSensor& sensor) {
  return has_other_noise(sensor) || most(sensor.white) > 0 || most(sensor.walk) > 0;
}

Model alone(const ModelEffect& effect) {
  Model one;
  one.set(effect.definition, effect.parameters);
  return one;
}

// Allan variance of an axis, as IEEE Std 952 has it, and of vibrations in samples of this rate.
double allan_variance(const InertialSensor& sensor, size_t axis, double tau_s, double rate_hz) {
  const auto square = [](double x) { return x * x; };
  double of_lines = 0;
  for (const effects::Vibration& line : sensor.vibrations)
    of_lines += effects::vibration_allan_variance(
        line, axis, std::max(1.0, std::round(tau_s * rate_hz)), 1 / rate_hz);
  return of_lines + square(sensor.white[axis]) / tau_s +
         2 * std::log(2) / maths::kPi * square(sensor.flicker[axis]) +
         square(sensor.walk[axis]) * tau_s / 3 + 3 * square(sensor.rounding[axis] / tau_s);
}

// By how much the noise of a sensor comes out too small without what was dropped, and where most.
std::string cost_of(const InertialSensor& with, const InertialSensor& without, double rate_hz) {
  double worst = 1, at_s = 0;
  for (const double tau_s : {0.01, 0.1, 1.0, 10.0, 100.0, 1000.0}) {
    for (size_t axis = 0; axis < 3; ++axis) {
      const double all = allan_variance(with, axis, tau_s, rate_hz),
                   left = allan_variance(without, axis, tau_s, rate_hz);
      const double ratio = left > 0 ? std::sqrt(all / left) : all > 0 ? HUGE_VAL : 1;
      if (ratio > worst) worst = ratio, at_s = tau_s;
    }
  }
  return fmt::format(
      "means over {:g} s scatter {:.3g} times as much as the file says, which is what people make "
      "up for by larger numbers",
      at_s, worst);
}

}  // namespace

std::string kalibr_imu_text(const PlainImu& imu) {
  return fmt::format(
      "# Densities of continuous time; of three axes the noisiest.\n"
      "accelerometer_noise_density: {:.9g}\naccelerometer_random_walk: {:.9g}\n"
      "gyroscope_noise_density: {:.9g}\ngyroscope_random_walk: {:.9g}\n"
      "rostopic: /imu0\nupdate_rate: {:.9g}\n",
      imu.accel_white, imu.accel_walk, imu.gyro_white, imu.gyro_walk, imu.rate_hz);
}

// VINS adds these up a sample at a time: a density counts for the root of the rate.
std::string vins_imu_text(const PlainImu& imu) {
  const double root = std::sqrt(imu.rate_hz);
  return fmt::format(
      "%YAML:1.0\n# Of single samples, {:.6g} a second; of three axes the noisiest.\n"
      "acc_n: {:.9g}\ngyr_n: {:.9g}\nacc_w: {:.9g}\ngyr_w: {:.9g}\n",
      imu.rate_hz, root * imu.accel_white, root * imu.gyro_white, root * imu.accel_walk,
      root * imu.gyro_walk);
}

Exported export_rig(const Model& model, const ExchangeFormat& format,
                    const ExportOptions& options) {
  check_drops(model, options);
  const effects::Inertial rig = effects::inertial_of(model);
  if (rig.camera_offset_s == 0 && rig.camera_turn_rad == effects::Triad{})
    throw InputError(
        fmt::format("{} holds how a camera and an inertial sensor stand to each other, expected a "
                    "model with 'camera_imu_offset' or 'camera_imu_rotation'",
                    format.name));
  Exported out{.text = format.text_of_rig(rig), .form = "", .notes = {}};
  if (rig.camera_offset_of_exposure != 0)
    out.notes.push_back(
        fmt::format("the file holds one offset, that of no exposure: add {:.6g} times the exposure "
                    "of a run to it",
                    rig.camera_offset_of_exposure));
  out.notes.emplace_back("the lever arm between both is 0 in the file: no turn shows it");
  return out;
}

// R_CI gives vectors in the sensor's axes in those of the camera; their time is the camera's plus
// the shift.
std::string kalibr_rig_text(const effects::Inertial& inertial) {
  const Mat3 R_IC = effects::camera_axes(inertial);
  std::string text =
      "# The lever arm is not estimated: its three numbers are 0.\ncam0:\n  T_cam_imu:\n";
  for (int row = 0; row < 3; ++row)
    text += fmt::format("  - [{:.12f}, {:.12f}, {:.12f}, 0.0]\n", R_IC[row][0], R_IC[row][1],
                        R_IC[row][2]);
  return text + fmt::format("  - [0.0, 0.0, 0.0, 1.0]\n  timeshift_cam_imu: {:.9g}\n",
                            inertial.camera_offset_s);
}

// The camera's pose in the axes of the sensor, and the same shift of time.
std::string vins_rig_text(const effects::Inertial& inertial) {
  const Mat3 R_IC = effects::camera_axes(inertial);
  std::string text =
      "%YAML:1.0\n# The lever arm is not estimated: its three numbers are 0.\n"
      "body_T_cam0: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n   data: [";
  for (int row = 0; row < 3; ++row)
    text += fmt::format("{:.12f}, {:.12f}, {:.12f}, 0.0,\n          ", R_IC[0][row], R_IC[1][row],
                        R_IC[2][row]);
  return text + fmt::format("0.0, 0.0, 0.0, 1.0]\ntd: {:.9g}\n", inertial.camera_offset_s);
}

Exported export_imu(const Model& model, const ExchangeFormat& format,
                    const ExportOptions& options) {
  check_drops(model, options);
  const effects::Inertial all = effects::inertial_of(model);
  if (!(most(all.gyro.white) > 0) || !(most(all.accel.white) > 0))
    throw InputError(
        fmt::format("{} holds the noise of a gyroscope and an accelerometer, expected a model with "
                    "'gyro_white_noise' and 'accel_white_noise'",
                    format.name));
  if (!(options.rate_hz > 0))
    throw UsageError(fmt::format(
        "{} holds the rate of the samples: give --data SET, from which it is taken", format.name));
  Exported out;
  std::vector<std::string> beside;
  Model kept = model;
  for (const ModelEffect& effect : model.effects()) {
    const std::string& name = effect.definition->name;
    const effects::Inertial own = effects::inertial_of(alone(effect));
    const bool lost = has_other_noise(own.gyro) || has_other_noise(own.accel);
    if (!has_noise(own.gyro) && !has_noise(own.accel)) beside.push_back(name);
    const auto asked = [&](const std::string& word) {
      return std::find(options.drop.begin(), options.drop.end(), word) != options.drop.end();
    };
    if (!lost && !asked(name)) continue;
    kept.remove(name);
    const effects::Inertial rest = effects::inertial_of(kept);
    const std::string cost = has_noise(own.gyro) ? cost_of(all.gyro, rest.gyro, options.rate_hz)
                                                 : cost_of(all.accel, rest.accel, options.rate_hz);
    if (!asked(name) && !asked("all"))
      throw InputError(
          fmt::format("{} cannot hold effect '{}' ({}): export with --drop {} to leave it out, or "
                      "--drop all",
                      format.name, name, cost, name));
    out.notes.push_back(fmt::format("without {}: {}", name, cost));
  }
  if (!beside.empty())
    out.notes.push_back(
        fmt::format("not in the file, since it is no noise: {}; take it out of the readings",
                    fmt::join(beside, ", ")));
  const effects::Inertial held = effects::inertial_of(kept);
  out.text = format.text_of_imu({.gyro_white = most(held.gyro.white),
                                 .gyro_walk = most(held.gyro.walk),
                                 .accel_white = most(held.accel.white),
                                 .accel_walk = most(held.accel.walk),
                                 .rate_hz = options.rate_hz});
  return out;
}

}  // namespace seam::app
