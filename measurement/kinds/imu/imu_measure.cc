// Makes a set of inertial sensors: what the model would report by a protocol's times.
#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/stages/inertial/vibration.h"
#include "measurement/kinds/imu/imu.h"
#include "measurement/kinds/imu/spectra/cosine_transform.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// Noise of one axis over a stretch: lines of the model's power, turned into a series.
std::vector<double> noise_of(const effects::InertialSensor& sensor, size_t axis, double stated,
                             const ImuStretch& stretch, RandomStream stream) {
  const size_t n = stretch.rows.size();
  std::vector<double> lines(n);
  for (size_t k = 0; k < n; ++k) {
    // The mean of a stretch wanders as lines do half a line before the first one.
    const double omega = omega_of_line(k == 0 ? 0.5 : static_cast<double>(k), n);
    double power = stated * stated + effects::smooth_noise_power(sensor, axis, omega, stretch.dt_s);
    const double here = static_cast<double>(k);
    for (const effects::Vibration& one : sensor.vibrations)
      power += effects::vibration_power_between(one, axis, omega_of_line(here - 0.5, n),
                                                omega_of_line(here + 0.5, n),
                                                static_cast<double>(n), stretch.dt_s);
    lines[k] = std::sqrt(power) * normal(stream, k);
  }
  return inverse_cosine_transform(lines);
}

std::vector<double> stamps_by(const effects::Inertial& inertial, const ImuData& data,
                              const CsvTable& table, const MeasureOptions& options,
                              const RandomStream& stream) {
  std::vector<double> stamp_s;
  for (const int64_t at_ns : table.times_ns("time_s"))
    stamp_s.push_back(1e-9 * static_cast<double>(at_ns));
  for (size_t s = 0; s < data.stretches.size(); ++s) {
    const ImuStretch& stretch = data.stretches[s];
    const double start_s = stamp_s[stretch.rows.front()];
    const RandomStream late = stream.child("stamps").child(s);
    const double most = 0.49 * stretch.dt_s;  // The next one never comes before it.
    for (size_t i = 0; i < stretch.rows.size(); ++i) {
      double at_s = start_s + stretch.stamp_s[i] / (1 + 1e-6 * inertial.clock_ppm);
      if (options.noise) at_s += std::clamp(inertial.stamp_sigma_s * normal(late, i), -most, most);
      stamp_s[stretch.rows[i]] = at_s;
    }
  }
  return stamp_s;
}

}  // namespace

void measure_imu(const Model& truth, const MeasurementSet& protocol,
                 const MeasureOptions& options) {
  if (protocol.has_file("attitudes"))
    throw InputError(fmt::format(
        "{}: a protocol with the attitudes of a camera, expected one of readings alone: what turns "
        "a body between two views is not known",
        protocol.root.file()));
  const ImuData data = read_imu(protocol, false);
  const CsvTable table = protocol.table("imu");
  const effects::Inertial inertial = effects::inertial_of(truth);
  const RandomStream stream = RandomStream{.seed = options.seed}.child("measure").child("imu");
  std::vector<std::vector<double>> columns(
      kImuAxes, std::vector<double>(table.rows(), std::numeric_limits<double>::quiet_NaN()));
  for (size_t s = 0; s < data.stretches.size(); ++s) {
    const ImuStretch& stretch = data.stretches[s];
    effects::InertialSample truth_here{.force_mps2 = Vec3(0, 0, data.gravity_mps2)};
    for (int axis = 0; axis < 3; ++axis) {
      const auto index = static_cast<size_t>(axis);
      truth_here.rate_radps[axis] = stretch.truth[index];
      if (data.knows_forces) truth_here.force_mps2[axis] = stretch.truth[index + 3];
    }
    for (size_t axis = 0; axis < kImuAxes; ++axis) {
      const auto& sensor = axis < 3 ? inertial.gyro : inertial.accel;
      std::vector<double> noise(stretch.rows.size(), 0);
      if (options.noise)
        noise = noise_of(sensor, axis % 3, protocol.noise_of(kImuColumns[axis]), stretch,
                         stream.child(s).child(axis));
      for (size_t i = 0; i < stretch.rows.size(); ++i) {
        const double warmth =
            stretch.temperature_c.empty() ? effects::kBiasAt_c : stretch.temperature_c[i];
        const auto read = effects::measured_by(inertial, truth_here, warmth);
        const int along = static_cast<int>(axis % 3);
        columns[axis][stretch.rows[i]] =
            (axis < 3 ? read.rate_radps[along] : read.force_mps2[along]) + noise[i];
      }
    }
  }
  // The sensor's clock says when samples are taken, and the host stamps them.
  const bool stamps = inertial.clock_ppm != 0 || inertial.stamp_sigma_s > 0;
  std::vector<std::string> names = {kImuColumns.begin(), kImuColumns.end()};
  if (stamps) {
    names.emplace_back("time_s");
    columns.push_back(stamps_by(inertial, data, table, options, stream));
  }
  copy_protocol(protocol, options.out, {"imu"});
  write_table_with(table, names, columns, written_path(options.out, protocol.files.at("imu")));
}

}  // namespace seam::measurement
