// Of which effects a set of inertial sensors can say anything, and where their fits start.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "measurement/kinds/imu/imu.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// A band of powers as a line of noise would raise it.
struct Raised {
  size_t axis = 0;
  double at_hz = 0, wide_hz = 0;
  double dt_s = 0;
  double excess = 0, sigma = 0;  // Of its power over the smooth spectrum,
  double smooth = 0;             // and that.
};

// By how much a line of unit variance would raise it; about, since starts need no more.
double raised_by(const Raised& band, double frequency_hz, double width_hz) {
  const double wide_hz = width_hz + band.wide_hz;
  return height_at({frequency_hz, wide_hz}, band.at_hz) /
         (maths::kPi * wide_hz * band.dt_s * band.smooth);
}

struct LineSeen {
  double gain = 0;  // Of chi-square.
  effects::Triad rms{};
};

LineSeen line_seen(const std::vector<Raised>& bands, double frequency_hz, double width_hz) {
  std::array<double, kImuAxes / 2> along{}, square{};
  for (const Raised& band : bands) {
    const double shape = raised_by(band, frequency_hz, width_hz) / band.sigma;
    along[band.axis] += shape * band.excess / band.sigma;
    square[band.axis] += shape * shape;
  }
  LineSeen seen;
  for (size_t axis = 0; axis < along.size(); ++axis) {
    if (!(square[axis] > 0)) continue;
    // An axis without the line starts from what chance makes of it: at 0 powers have no slope.
    const double error = 1 / std::sqrt(square[axis]), variance = along[axis] / square[axis];
    seen.rms[axis] = std::sqrt(std::max(variance, error));
    if (variance > 0) seen.gain += variance * along[axis];
  }
  return seen;
}

}  // namespace

// Whether gravity is seen along directions that differ by far more than a tilt.
bool ImuProblem::sees_attitudes() const {
  constexpr double kApart = 0.9;  // Cosine: 26 degrees.
  if (!data_.has[3]) return false;
  const Vec3 first = force_read(data_.stretches.front());
  return std::any_of(data_.stretches.begin(), data_.stretches.end(), [&](const ImuStretch& other) {
    const Vec3 there = force_read(other);
    const double along = first[0] * there[0] + first[1] * there[1] + first[2] * there[2];
    return along < kApart * size_of(first) * size_of(there);
  });
}

bool ImuProblem::turns() const {
  return std::any_of(data_.stretches.begin(), data_.stretches.end(), [](const ImuStretch& stretch) {
    return stretch.truth[0] != 0 || stretch.truth[1] != 0 || stretch.truth[2] != 0;
  });
}

bool ImuProblem::warmth_changes() const {
  constexpr double kLeast_k = 0.2;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const ImuStretch& stretch : data_.stretches) {
    for (const double t : stretch.temperature_c) low = std::min(low, t), high = std::max(high, t);
  }
  return high - low > kLeast_k;
}

bool ImuProblem::stamps_scatter() const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [](const Row& row) { return row.what == Row::What::jitter; });
}

// Why the set says nothing of what these sensors have wrong; empty: it says something.
std::string ImuProblem::lacking(const effects::Inertial& by) const {
  const effects::Triad none{};
  const auto differs = [&](const effects::InertialSensor& sensor) {
    return sensor.bias != none || sensor.per_k != none || sensor.scale != none ||
           sensor.cross != decltype(sensor.cross){} || sensor.most != effects::kNever ||
           sensor.white != none || sensor.flicker != none || sensor.walk != none ||
           sensor.rounding != none || !sensor.vibrations.empty();
  };
  const bool shows_force = by.gyro_per_force != none;
  if ((differs(by.gyro) || shows_force) && !data_.has[0]) return "no gyroscope was read";
  if ((differs(by.accel) || shows_force) && !data_.has[3]) return "no accelerometer was read";
  if (is_of_camera(by)) return "no camera was beside the sensor: the set has no attitudes";
  if (by.clock_ppm != 0 && !(data_.rate_hz > 0))
    return "the set does not say at which rate the sensor samples by its own clock (rate_hz)";
  if (by.stamp_sigma_s > 0 && !(data_.rate_hz > 0))
    return "nothing is asked of the time stamps: the set has no rate_hz";
  if (by.stamp_sigma_s > 0 && !stamps_scatter()) return "the time stamps are even";
  if ((by.gyro.per_k != none || by.accel.per_k != none) && !warmth_changes())
    return "no temperature was logged, or it stays the same";
  const auto moves_vectors = [](const effects::InertialSensor& sensor) {
    return sensor.scale != effects::Triad{} || sensor.cross != decltype(sensor.cross){} ||
           sensor.most != effects::kNever;
  };
  if (moves_vectors(by.gyro) && !turns())
    return "the sensor rests in every stretch, or its rates are unknown";
  if ((moves_vectors(by.accel) || by.accel.bias != none || shows_force) && !attitudes_)
    return "gravity is seen along one direction alone";
  return "";
}

std::string ImuProblem::not_testable(const Model& model, const EffectDefinition& effect,
                                     size_t parameter) const {
  if (effect.noise) {
    if (std::string why = lacking(tried_alone(effect, parameter)); !why.empty()) return why;
  }
  return Problem::not_testable(model, effect, parameter);
}

// The end of a range is at the largest reading seen, or beyond it.
std::vector<std::vector<double>> ImuProblem::starts(const Model& model,
                                                    const EffectDefinition& effect) const {
  const effects::StartSearch search = effects::start_rule(effect, facts_.set.kind).search;
  if (search == effects::StartSearch::frequency)
    return line_starts(model, effect, folds().size() == 1 ? training_groups() : all_groups());
  if (search != effects::StartSearch::ceiling) return Problem::starts(model, effect);
  effects::Noise ends;
  const std::vector<double> nearest = {effect.parameters[0].min};
  effect.noise(nearest, ends);
  double most = nearest[0];
  for (const Row& row : rows_) {
    const bool ended = sensor(ends.inertial, row.axis).most == nearest[0];
    if (ended && row.what == Row::What::mean) most = std::max(most, std::abs(row.observed));
  }
  return {{most}};
}

std::vector<std::vector<double>> ImuProblem::starts_on(const Groups& groups, const Model& model,
                                                       const EffectDefinition& effect,
                                                       const EffectList& companions) const {
  if (effects::start_rule(effect, facts_.set.kind).search == effects::StartSearch::frequency)
    return line_starts(model, effect, groups);
  return Problem::starts_on(groups, model, effect, companions);
}

// Each band of the longest stretch is a place where a line was looked for.
double ImuProblem::looks(const Model& model, const EffectDefinition& effect) const {
  if (effects::start_rule(effect, facts_.set.kind).search != effects::StartSearch::frequency)
    return Problem::looks(model, effect);
  const size_t axis = axis_of_line(effect), longest = longest_stretch();
  return static_cast<double>(std::count_if(rows_.begin(), rows_.end(), [&](const Row& row) {
    return row.what == Row::What::power && row.axis == axis && row.stretch == longest;
  }));
}

// The first axis of the sensor in whose readings the effect puts a line.
size_t ImuProblem::axis_of_line(const EffectDefinition& effect) const {
  std::vector<double> values;
  for (const effects::Parameter& one : effect.parameters) values.push_back(one.neutral);
  effects::Noise noise;
  effect.noise(values, noise);
  return noise.inertial.gyro.vibrations.empty() ? 3 : 0;
}

// The line that takes most of what the model leaves of the powers in these groups.
std::vector<std::vector<double>> ImuProblem::line_starts(const Model& model,
                                                         const EffectDefinition& effect,
                                                         const Groups& groups) const {
  const effects::Inertial inertial = effects::inertial_of(model);
  const size_t first = axis_of_line(effect), longest = longest_stretch();
  std::vector<Raised> bands, places;
  for (size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.what != Row::What::power || row.axis < first || row.axis >= first + 3) continue;
    const ImuStretch& stretch = data_.stretches[row.stretch];
    const double hz = omega_of_line(1, stretch.rows.size()) / (2 * maths::kPi * stretch.dt_s);
    const double middle = 0.5 * static_cast<double>(row.first + row.last - 1);
    const double seen = row.observed * row.observed * row.observed / 27;
    const double expected = power_ratio(row, inertial);
    const double root = std::cbrt(std::max(seen, expected));
    const Raised band{
        .axis = row.axis - first,
        .at_hz = middle * hz,
        .wide_hz = static_cast<double>(row.last - row.first) * hz,
        .dt_s = stretch.dt_s,
        .excess = seen - expected,
        .sigma = row.sigma * root * root,
        .smooth = noise_[row.axis].smooth.at(omega_of_line(middle, stretch.rows.size()))};
    if (row.stretch == longest) places.push_back(band);
    if (groups[static_cast<size_t>(facts_.group_of_row[i])]) bands.push_back(band);
  }
  constexpr double kWidest = 0.5;  // Of the frequency: what is wider is no line.
  LineSeen best;
  std::vector<double> start = {0, 0, 0, effect.parameters[3].neutral, effect.parameters[4].neutral,
                               0};
  for (const Raised& place : places) {
    for (double wide_hz = place.wide_hz / 2; wide_hz < kWidest * place.at_hz; wide_hz *= 2) {
      const LineSeen seen = line_seen(bands, place.at_hz, wide_hz);
      if (!(seen.gain > best.gain)) continue;
      best = seen;
      start = {seen.rms[0], seen.rms[1], seen.rms[2], place.at_hz, place.at_hz / wide_hz, 0};
    }
  }
  return {start};
}

}  // namespace seam::measurement
