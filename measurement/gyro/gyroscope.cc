#include "measurement/gyro/gyroscope.h"

#include <fmt/format.h>

#include <algorithm>

#include "measurement/numerics/robust.h"
#include "measurement/sets/temperatures.h"
#include "sim_core/base/error.h"
#include "sim_core/body/turn.h"

namespace seam::measurement {
namespace {

// Steps of the sensor's time longer than so many usual ones are gaps.
constexpr double kGapOfGyroscope = 3;

}  // namespace

effects::Inertial tried_alone(const effects::EffectDefinition& effect, size_t parameter) {
  std::vector<double> values;
  for (const effects::Parameter& one : effect.parameters) values.push_back(one.neutral);
  const effects::Parameter& tried = effect.parameters[parameter];
  values[parameter] = tried.fit_reciprocal ? tried.scale : tried.neutral + tried.scale;
  effects::Noise noise;
  if (effect.noise) effect.noise(values, noise);
  return noise.inertial;
}

bool is_of_camera(const effects::Inertial& by) {
  return by.camera_offset_s != 0 || by.camera_offset_of_exposure != 0 ||
         by.camera_turn_rad != effects::Triad{};
}

bool moves_rates(const effects::InertialSensor& gyro) {
  const effects::Triad none{};
  return gyro.bias != none || gyro.per_k != none || gyro.scale != none ||
         gyro.cross != decltype(gyro.cross){};
}

void expect_later(const CsvTable& table, const std::vector<int64_t>& time_ns, size_t row) {
  if (row > 0 && time_ns[row] <= time_ns[row - 1])
    table.fail(row, "time_s", table.cell(row, "time_s"),
               "a later time than that of the row before");
}

Gyroscope read_gyroscope(const MeasurementSet& set, int64_t& first_ns) {
  Gyroscope data;
  const CsvTable table = set.table("imu");
  std::vector<std::vector<double>> columns;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (!table.has(kImuColumns[axis]))
      throw InputError(fmt::format("{}: found no column {}, expected a gyroscope's {}, {}, {}",
                                   table.file(), kImuColumns[axis], kImuColumns[0], kImuColumns[1],
                                   kImuColumns[2]));
    columns.push_back(table.numbers(kImuColumns[axis]));
  }
  const std::vector<int64_t> time_ns = table.times_ns("time_s");
  if (table.has(kTemperature)) data.temperature_c = table.numbers(kTemperature);
  if (table.rows() < kLeastSamples)
    throw InputError(fmt::format("{}: found {} samples, expected {} or more", table.file(),
                                 table.rows(), kLeastSamples));
  first_ns = time_ns.front();
  for (size_t row = 0; row < table.rows(); ++row) {
    expect_later(table, time_ns, row);
    data.at_s.push_back(1e-9 * static_cast<double>(time_ns[row] - first_ns));
    data.rate_radps.emplace_back(columns[0][row], columns[1][row], columns[2][row]);
  }
  return data;
}

double usual_step_s(const Gyroscope& gyroscope) {
  std::vector<double> steps;
  for (size_t i = 1; i < gyroscope.at_s.size(); ++i)
    steps.push_back(gyroscope.at_s[i] - gyroscope.at_s[i - 1]);
  return median_of(steps);
}

bool reads_all(const Gyroscope& gyroscope, double usual_s, double from_s, double to_s) {
  const std::vector<double>& at = gyroscope.at_s;
  if (from_s < at.front() || to_s > at.back()) return false;
  auto i = static_cast<size_t>(std::upper_bound(at.begin(), at.end(), from_s) - at.begin());
  for (; i < at.size() && at[i - 1] < to_s; ++i)
    if (at[i] - at[i - 1] > kGapOfGyroscope * usual_s) return false;
  return true;
}

GyroPath::GyroPath(const Gyroscope& data, const effects::Inertial& inertial) : gyroscope_(&data) {
  const auto read = [&](const Vec3& rate, size_t sample) {
    const double warmth =
        data.temperature_c.empty() ? effects::kBiasAt_c : data.temperature_c[sample];
    return effects::measured_by(inertial, {.rate_radps = rate}, warmth).rate_radps;
  };
  // Readings are linear in the rate.
  Mat3 by_rate;
  const Vec3 none = read(Vec3(0.0), 0);
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 one(0.0);
    one[axis] = 1;
    by_rate[axis] = read(one, 0) - none;
  }
  const Mat3 back = glm::inverse(by_rate);
  rate_.resize(data.at_s.size());
  R_0I_.assign(data.at_s.size(), Mat3(1.0));
  for (size_t i = 0; i < data.at_s.size(); ++i) {
    rate_[i] = back * (data.rate_radps[i] - read(Vec3(0.0), i));
    if (i == 0) continue;
    const double step_s = data.at_s[i] - data.at_s[i - 1];
    R_0I_[i] = R_0I_[i - 1] * rotation_by(0.5 * step_s * (rate_[i - 1] + rate_[i]));
  }
}

size_t GyroPath::before(double at_s) const {
  const std::vector<double>& at = gyroscope_->at_s;
  const auto next = static_cast<size_t>(std::upper_bound(at.begin(), at.end(), at_s) - at.begin());
  return std::clamp<size_t>(next, 1, at.size() - 1) - 1;
}

Vec3 GyroPath::rate(double at_s) const {
  const size_t i = before(at_s);
  const double step_s = gyroscope_->at_s[i + 1] - gyroscope_->at_s[i];
  const double share = std::clamp((at_s - gyroscope_->at_s[i]) / step_s, 0.0, 1.0);
  return rate_[i] + share * (rate_[i + 1] - rate_[i]);
}

Mat3 GyroPath::attitude(double at_s) const {
  const size_t i = before(at_s);
  return R_0I_[i] * rotation_by(0.5 * (at_s - gyroscope_->at_s[i]) * (rate_[i] + rate(at_s)));
}

Vec3 GyroPath::turn(double from_s, double to_s) const {
  return turn_of(glm::transpose(attitude(from_s)) * attitude(to_s));
}

}  // namespace seam::measurement
