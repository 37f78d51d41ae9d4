#include "measurement/kinds/imu/imu.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/stages/inertial/vibration.h"
#include "measurement/kinds/imu/imu_camera.h"
#include "measurement/kinds/imu/spectra/allan.h"
#include "measurement/kinds/imu/stamps.h"
#include "measurement/numerics/robust.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kParts = 6;  // Fewer than kFewGroups, so that each is held out in turn.

std::string power_name(size_t axis) {
  return std::string(kImuColumns[axis], 2) + "_power";
}

std::vector<std::string> groups_of(const ImuData& data) {
  std::vector<std::string> names;
  for (const ImuStretch& stretch : data.stretches) {
    if (std::find(names.begin(), names.end(), stretch.group) == names.end())
      names.push_back(stretch.group);
  }
  return names;
}

}  // namespace

ImuProblem::ImuProblem(const MeasurementSet& set) : data_(read_imu(set, true)) {
  facts_.set.kind = effects::kImu;
  facts_.title = set.title;
  facts_.fingerprint = set.fingerprint();
  facts_.file = set.file("imu").string();
  facts_.tests_neighbours = false;
  attitudes_ = sees_attitudes();
  add_rows(set);
  add_covariates();
  if (data_.left > 0)
    facts_.notes.push_back(fmt::format(
        "{} samples take no part: they lie in no stretch of {} samples or more with even times and "
        "one reference, are blank, or stand behind a length whose spectrum is quick to find",
        data_.left, kLeastSamples));
}

void ImuProblem::add_rows(const MeasurementSet& set) {
  const bool many = groups_of(data_).size() >= kFewGroups;
  const size_t parts = many ? 1 : kParts;
  const auto group_of = [&](size_t stretch, size_t part) {
    return many ? data_.stretches[stretch].group : fmt::format("part {}", part + 1);
  };
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    stated_[axis] = set.noise_of(kImuColumns[axis]);
    if (data_.has[axis]) noise_[axis] = noise_of_axis(data_, axis, parts, many ? 0.125 : 0.02);
  }
  for (size_t s = 0; s < data_.stretches.size(); ++s) {
    for (size_t part = 0; part < parts; ++part) add_means(s, part, group_of(s, part));
  }
  for (size_t s = 0; s < data_.stretches.size() && data_.rate_hz > 0; ++s) {
    std::vector<std::string> in_turn;
    for (size_t part = 0; part < parts; ++part) in_turn.push_back(group_of(s, part));
    add_stamps(s, in_turn);
  }
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    size_t number = 0;
    for (const NoiseBand& band : noise_[axis].bands)
      add_power(band, axis, group_of(band.stretch, number++ % parts));
  }
  for (size_t c = 0; c < facts_.channels.size(); ++c) {
    std::vector<double> sigmas;
    for (size_t i = 0; i < rows_.size(); ++i)
      if (facts_.channel_of[i] == static_cast<int>(c)) sigmas.push_back(rows_[i].sigma);
    facts_.channels[c].noise = median_of(sigmas);
  }
}

void ImuProblem::add_means(size_t stretch, size_t part, const std::string& group) {
  double variance = 0;
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    if (!data_.has[axis]) continue;
    const StretchMean& mean = noise_[axis].means[stretch][part];
    const std::string channel = kImuColumns[axis];
    Row row{.stretch = stretch, .axis = axis, .part = part};
    if (axis < 3 || data_.knows_forces) {
      row.what = Row::What::mean, row.observed = mean.value, row.sigma = std::sqrt(mean.variance);
      add_row(row, channel, group);
    }
    if (mean.per_k_variance > 0) {
      row.what = Row::What::per_k, row.observed = mean.per_k;
      row.sigma = std::sqrt(mean.per_k_variance);
      add_row(row, channel + "_k", group);
    }
    if (axis >= 3) variance += mean.variance / 3;
  }
  if (!data_.knows_forces && data_.has[3] && (attitudes_ || groups_of(data_).size() > 1))
    add_row({.what = Row::What::gravity,
             .stretch = stretch,
             .axis = 3,
             .part = part,
             .observed = data_.gravity_mps2,
             .sigma = std::sqrt(variance)},
            "gravity_mps2", group);
}

void ImuProblem::add_stamps(size_t stretch, const std::vector<std::string>& groups) {
  const auto parts = stamps_of(data_.stretches[stretch], groups.size(), data_.rate_hz);
  double scale = 0, freedom = 0;
  for (const StampPart& part : parts)
    scale += part.freedom * part.variance_s2, freedom += part.freedom;
  for (size_t part = 0; part < parts.size(); ++part) {
    const StampPart& one = parts[part];
    Row row{.stretch = stretch, .part = part};
    row.what = Row::What::clock, row.observed = one.drift_ppm;
    row.sigma = std::sqrt(one.drift_variance);
    add_row(row, "clock_ppm", groups[part]);
    if (!(one.freedom > 0)) continue;
    // As a power: the cube root of a variance, over that of the whole stretch.
    row.what = Row::What::jitter, row.freedom = one.freedom, row.scale = scale / freedom;
    row.observed = 3 * std::cbrt(one.variance_s2 / row.scale);
    row.sigma = std::sqrt(2 / one.freedom + kPowerAccuracy * kPowerAccuracy);
    add_row(row, "stamps_power", groups[part]);
  }
}

void ImuProblem::add_power(const NoiseBand& band, size_t axis, const std::string& group) {
  // Where lines are few, the smooth spectrum says better than their power how far it scatters.
  constexpr double kMany = 64;
  const double shape = band.freedom / 2, root = std::cbrt(band.power);
  const double scale = band.freedom > kMany ? root : 1;
  add_row({.what = Row::What::power,
           .stretch = band.stretch,
           .axis = axis,
           .observed = 3 * root,
           .sigma = scale * std::sqrt(1 / shape + kPowerAccuracy * kPowerAccuracy),
           .freedom = band.freedom,
           .first = band.first,
           .last = band.last},
          power_name(axis), group);
}

void ImuProblem::add_row(Row row, const std::string& channel, const std::string& group) {
  const auto number = [](auto& list, const auto& same, auto make) {
    const auto at = std::find_if(list.begin(), list.end(), same);
    if (at != list.end()) return static_cast<int>(at - list.begin());
    list.push_back(make());
    return static_cast<int>(list.size()) - 1;
  };
  facts_.channel_of.push_back(number(
      facts_.channels, [&](const Channel& c) { return c.name == channel; },
      [&] { return Channel{.name = channel}; }));
  facts_.group_of_row.push_back(number(
      facts_.groups, [&](const std::string& g) { return g == group; }, [&] { return group; }));
  const ImuStretch& stretch = data_.stretches[row.stretch];
  facts_.row_of.push_back(static_cast<int>(rows_.size()));
  facts_.line_of_row.push_back(static_cast<int>(stretch.rows.front()) + 2);
  // Powers are independent of each other: their order is that of frequencies.
  facts_.time_of_row.push_back(stretch.start_s + 1e-3 * static_cast<double>(row.first));
  rows_.push_back(row);
}

void ImuProblem::add_covariates() {
  const size_t n = rows_.size();
  std::vector<double> frequency(n, kUnknown), time(n, kUnknown), warmth(n, kUnknown);
  std::array<std::vector<double>, kImuAxes> truth;
  truth.fill(std::vector<double>(n, kUnknown));
  for (size_t i = 0; i < n; ++i) {
    const Row& row = rows_[i];
    const ImuStretch& stretch = data_.stretches[row.stretch];
    if (row.what == Row::What::power) {
      const double middle = 0.5 * static_cast<double>(row.first + row.last - 1);
      frequency[i] =
          std::log10(omega_of_line(middle, stretch.rows.size()) / (2 * maths::kPi * stretch.dt_s));
      continue;
    }
    time[i] = stretch.start_s;
    warmth[i] = stretch.warmth_c.value_or(kUnknown);
    for (size_t axis = 0; axis < kImuAxes; ++axis) truth[axis][i] = stretch.truth[axis];
  }
  auto& all = facts_.covariates;
  all.push_back({.name = "log_frequency", .values = std::move(frequency), .in_products = false});
  if (data_.stretches.size() < 2) return;
  all.push_back({.name = "time", .values = std::move(time)});
  if (!data_.stretches.front().temperature_c.empty())
    all.push_back({.name = "temperature", .values = std::move(warmth)});
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    if (axis < 3 ? data_.knows_rates : data_.knows_forces)
      all.push_back({.name = kImuTruth[axis], .values = std::move(truth[axis])});
  }
}

double ImuProblem::reading_of(const Row& row, const effects::Inertial& inertial,
                              double warmer_k) const {
  const ImuStretch& stretch = data_.stretches[row.stretch];
  effects::InertialSample truth;
  const Vec3 seen = data_.has[3] && !data_.knows_forces ? force_read(stretch) : Vec3(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<size_t>(axis);
    truth.rate_radps[axis] = stretch.truth[index];
    // What the accelerometer reads is near enough for a gyroscope's sensitivity.
    truth.force_mps2[axis] = data_.knows_forces ? stretch.truth[index + 3] : seen[axis];
  }
  const effects::InertialSample read = effects::measured_by(
      inertial, truth, stretch.warmth_c.value_or(effects::kBiasAt_c) + warmer_k);
  const int axis = static_cast<int>(row.axis % 3);
  return row.axis < 3 ? read.rate_radps[axis] : read.force_mps2[axis];
}

// How large the force is that the accelerometer would read so.
double ImuProblem::force_size(const Row& row, const effects::Inertial& inertial) const {
  constexpr int kMostSteps = 50;
  const ImuStretch& stretch = data_.stretches[row.stretch];
  const double warmth = stretch.warmth_c.value_or(effects::kBiasAt_c);
  Vec3 read(0.0);
  for (int axis = 0; axis < 3; ++axis)
    read[axis] = noise_[static_cast<size_t>(axis) + 3].means[row.stretch][row.part].value;
  if (!attitudes_) return size_of(read);  // Of which compare_forces takes the mean.
  effects::InertialSample truth{.force_mps2 = read};
  for (int step = 0; step < kMostSteps; ++step) {
    const Vec3 there = effects::measured_by(inertial, truth, warmth).force_mps2;
    const Vec3 off(read[0] - there[0], read[1] - there[1], read[2] - there[2]);
    for (int axis = 0; axis < 3; ++axis) truth.force_mps2[axis] += off[axis];
    if (size_of(off) < 1e-12 * size_of(read)) break;
  }
  return size_of(truth.force_mps2);
}

// The model's power over the smooth spectrum, as a mean over the band. But for lines their ratio
// changes little within it.
double ImuProblem::power_ratio(const Row& row, const effects::Inertial& inertial) const {
  constexpr size_t kPlaces = 4;
  const ImuStretch& stretch = data_.stretches[row.stretch];
  const size_t lines = row.last - row.first, places = std::min(kPlaces, lines);
  const double stated = stated_[row.axis] * stated_[row.axis];
  double sum = 0;
  for (size_t i = 0; i < places; ++i) {
    const double k =
        static_cast<double>(row.first) - 0.5 +
        (static_cast<double>(i) + 0.5) * static_cast<double>(lines) / static_cast<double>(places);
    const double omega = omega_of_line(k, stretch.rows.size());
    sum += (stated +
            effects::noise_power(sensor(inertial, row.axis), row.axis % 3, omega, stretch.dt_s)) /
           noise_[row.axis].smooth.at(omega);
  }
  return sum / static_cast<double>(places);
}

double ImuProblem::predicted(const Row& row, const effects::Inertial& inertial) const {
  switch (row.what) {
    case Row::What::mean:
      return reading_of(row, inertial, 0);
    case Row::What::per_k:
      return reading_of(row, inertial, 0.5) - reading_of(row, inertial, -0.5);
    case Row::What::gravity:
      return force_size(row, inertial);
    case Row::What::clock:
      return inertial.clock_ppm;
    case Row::What::jitter:
    case Row::What::power:
      break;
  }
  const double scattered = inertial.stamp_sigma_s * inertial.stamp_sigma_s;
  const double ratio = row.what == Row::What::power
                           ? power_ratio(row, inertial)
                           : (scattered + kEvenStamps_s * kEvenStamps_s) / row.scale;
  // The mean of the cube root of a power of so many degrees of freedom.
  return 3 * std::cbrt(ratio) * (1 - 2 / (9 * row.freedom));
}

Evaluation ImuProblem::evaluate(const Model& model, const Groups& groups, const Evaluation*) const {
  const effects::Inertial inertial = effects::inertial_of(model);
  Evaluation evaluation;
  evaluation.residual.assign(rows_.size(), 0);
  evaluation.sigma.assign(rows_.size(), 1);
  for (size_t i = 0; i < rows_.size(); ++i) {
    evaluation.sigma[i] = rows_[i].sigma;
    if (!groups[static_cast<size_t>(facts_.group_of_row[i])]) continue;
    evaluation.residual[i] = rows_[i].observed - predicted(rows_[i], inertial);
    evaluation.valid = evaluation.valid && std::isfinite(evaluation.residual[i]);
  }
  if (!attitudes_) compare_forces(groups, evaluation);
  whiten_diagonal(*this, groups, evaluation);
  return evaluation;
}

void ImuProblem::check_model(const Model& model) const {
  expect_inertial(*this, model);
}

void expect_inertial(const Problem& problem, const Model& model) {
  for (const effects::ModelEffect& effect : model.effects()) {
    if (problem.acts(*effect.definition)) continue;
    throw InputError(fmt::format(
        "effect '{}' does not act on inertial sensors, expected a model of a gyroscope or an "
        "accelerometer (seam effects lists them under `inertial`)",
        effect.definition->name));
  }
}

size_t ImuProblem::longest_stretch() const {
  const auto shorter = [](const ImuStretch& a, const ImuStretch& b) {
    return a.rows.size() < b.rows.size();
  };
  return static_cast<size_t>(
      std::max_element(data_.stretches.begin(), data_.stretches.end(), shorter) -
      data_.stretches.begin());
}

// Readings of the longest stretch without what the model makes of their temperature.
std::vector<double> ImuProblem::without_warmth(size_t axis,
                                               const effects::Inertial& inertial) const {
  const ImuStretch& longest = data_.stretches[longest_stretch()];
  std::vector<double> readings = longest.samples[axis];
  if (longest.temperature_c.empty()) return readings;
  const Row row{.stretch = longest_stretch(), .axis = axis};
  const double per_k = reading_of(row, inertial, 0.5) - reading_of(row, inertial, -0.5);
  for (size_t i = 0; i < readings.size(); ++i)
    readings[i] -= per_k * (longest.temperature_c[i] - longest.warmth_c.value_or(0));
  return readings;
}

std::vector<Curve> ImuProblem::curves(const Model& model) const {
  const ImuStretch& longest = data_.stretches[longest_stretch()];
  const effects::Inertial inertial = effects::inertial_of(model);
  std::vector<Curve> curves;
  for (size_t axis = 0; axis < kImuAxes; ++axis) {
    if (!data_.has[axis]) continue;
    const std::string column = kImuColumns[axis];
    Curve curve{.title = "Allan deviation of " + column.substr(0, 2),
                .of = column,
                .at_name = "averaged over",
                .at_unit = "s",
                .unit = axis < 3 ? "rad/s" : "m/s^2",
                .points = allan_deviation(without_warmth(axis, inertial), longest.dt_s)};
    for (CurvePoint& point : curve.points) {
      const double m = std::round(point.at / longest.dt_s);
      const effects::InertialSensor& by = sensor(inertial, axis);
      point.expected = allan_deviation_of(
          [&](double omega) {
            return stated_[axis] * stated_[axis] +
                   effects::smooth_noise_power(by, axis % 3, omega, longest.dt_s);
          },
          m);
      for (const effects::Vibration& line : by.vibrations)
        point.expected = std::hypot(point.expected, std::sqrt(effects::vibration_allan_variance(
                                                        line, axis % 3, m, longest.dt_s)));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

Kind imu_kind() {
  return {.bit = effects::kImu,
          .observations = {.file = "imu",
                           .keys = {"run", "time_s"},
                           .measured = {kImuColumns.begin(), kImuColumns.end()}},
          .open = [](const MeasurementSet& set, const Instruments&) -> std::unique_ptr<Problem> {
            if (set.has_file("attitudes")) return std::make_unique<ImuCameraProblem>(set);
            return std::make_unique<ImuProblem>(set);
          },
          .measure = [](const Model& truth, const MeasurementSet& protocol,
                        const MeasureOptions& options,
                        const Instruments&) { measure_imu(truth, protocol, options); }};
}

}  // namespace seam::measurement
