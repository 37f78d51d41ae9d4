#include "effects/stages/inertial/noise_series.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Places of a state; the wandering parts and the oscillators follow.
enum Place : size_t { kBegun, kWalk, kAdded, kFirstPart };

// Lorentzians an octave apart, whose sum is 1 / f: of samples 8 ms apart the slowest takes months.
constexpr int kOctaves = 28;
// Of a part that loses so much of itself from one sample to the next, samples know nothing.
constexpr double kQuickest = 4;

}  // namespace

NoiseSeries::NoiseSeries(const InertialSensor& sensor, size_t axis, double dt_s,
                         RandomStream stream)
    : dt_s_(dt_s),
      white_(sensor.white[axis] / std::sqrt(dt_s)),
      step_(sensor.walk[axis] * std::sqrt(dt_s)),
      rounded_to_(std::sqrt(12.0) * sensor.rounding[axis]),
      // Their densities add up to B^2 / omega where each has the variance B^2 ln 2 / pi.
      wander_sigma_(sensor.flicker[axis] * std::sqrt(maths::log(2) / maths::kPi)),
      stream_(stream) {
  for (int octave = 0; octave < kOctaves && wander_sigma_ > 0; ++octave)
    keeps_.push_back(maths::exp(-kQuickest * std::ldexp(1.0, -octave)));
  for (const Vibration& line : sensor.vibrations)
    if (line.rms[axis] > 0) swings_.push_back(swing_of(line, axis, dt_s));
}

NoiseSeries::Swing NoiseSeries::swing_of(const Vibration& line, size_t axis, double dt_s) {
  const double decay = maths::kPi * line.width_hz, turn = 2 * maths::kPi * line.frequency_hz;
  const double stays = maths::exp(-decay * dt_s), damped = decay / turn;
  const double cosine = stays * maths::cos(turn * dt_s), sine = stays * maths::sin(turn * dt_s);
  const double across = std::sqrt(1 + damped * damped) * sine;
  const double skew = std::clamp(line.skew, -1.0, 1.0);
  Swing swing{.rms = line.rms[axis],
              .deflection = std::sqrt((1 + skew) / 2),
              .rate = std::sqrt((1 - skew) / 2),
              .kept = {{cosine + damped * sine, across}, {-across, cosine - damped * sine}}};
  const auto lost = [&](int a, int b) {
    return (a == b ? 1.0 : 0.0) - swing.kept[a][0] * swing.kept[b][0] -
           swing.kept[a][1] * swing.kept[b][1];
  };
  swing.renewed[0] = std::sqrt(std::max(0.0, lost(0, 0)));
  swing.renewed[1] = swing.renewed[0] > 0 ? lost(0, 1) / swing.renewed[0] : 0;
  swing.renewed[2] = std::sqrt(std::max(0.0, lost(1, 1) - swing.renewed[1] * swing.renewed[1]));
  return swing;
}

size_t NoiseSeries::state_size() const {
  return kFirstPart + keeps_.size() + 2 * swings_.size();
}

double NoiseSeries::reading(double mean, uint64_t index, std::span<double> state) const {
  const RandomStream now = stream_.child(index);
  uint64_t number = 0;
  const auto draw = [&] { return normal(now, number++); };
  const bool begun = state[kBegun] != 0;
  state[kBegun] = 1;
  double value = mean + state[kWalk];
  if (white_ > 0) value += white_ * draw();
  if (step_ > 0) state[kWalk] += step_ * draw();
  double* part = &state[kFirstPart];
  for (const double keep : keeps_) {
    const double kept = begun ? keep : 0;
    *part = kept * *part + std::sqrt(1 - kept * kept) * draw();
    value += wander_sigma_ * *part++;
  }
  for (const Swing& swing : swings_) {
    double &x = part[0], &y = part[1];
    const double a = draw(), b = draw(), before = x;
    x = begun ? swing.kept[0][0] * x + swing.kept[0][1] * y + swing.renewed[0] * a : a;
    y = begun ? swing.kept[1][0] * before + swing.kept[1][1] * y + swing.renewed[1] * a +
                    swing.renewed[2] * b
              : b;
    value += swing.rms * (swing.deflection * x + swing.rate * y);
    part += 2;
  }
  if (!(rounded_to_ > 0)) return value;
  // It adds up and reports whole steps; the rest stays for the next sample.
  const double whole = std::round((state[kAdded] + value * dt_s_) / rounded_to_) * rounded_to_;
  state[kAdded] += value * dt_s_ - whole;
  return whole / dt_s_;
}

}  // namespace seam::effects
