#include "measurement/imaging/sensor_response.h"

#include <algorithm>
#include <cmath>

namespace seam::measurement {

using effects::Moments;
using effects::SensorChain;
using effects::SensorExposure;

namespace {

double square(double x) {
  return x * x;
}

// The average of f(x), x normal with mean 0 and standard deviation sd, where f changes over lengths
// of `scale`.
template <typename F>
double average(double sd, double scale, F&& f) {
  if (sd == 0) return f(0);
  static constexpr double kNode[] = {-2.856970013872806, -1.355626179974266, 0, 1.355626179974266,
                                     2.856970013872806};
  static constexpr double kWeight[] = {0.011257411327721, 0.222075922005613, 0.533333333333333,
                                       0.222075922005613, 0.011257411327721};
  double sum = 0;
  if (sd < 0.6 * scale) {
    for (int i = 0; i < 5; ++i) sum += kWeight[i] * f(sd * kNode[i]);
    return sum;
  }
  // Sums at equal steps, half a scale or less apart, are exact to a thousandth.
  constexpr double kReach = 4;
  const int half = static_cast<int>(std::clamp(2 * kReach * sd / scale, 8.0, 40.0));
  double weights = 0;
  for (int i = -half; i <= half; ++i) {
    const double z = kReach * i / half, weight = std::exp(-0.5 * z * z);
    sum += weight * f(sd * z), weights += weight;
  }
  return sum / weights;
}

}  // namespace

bool is_near_top(const SensorChain& chain, int file_bits, double dn) {
  return dn > 0.5 * std::min(chain.full_dn, effects::full_scale_dn(file_bits));
}

Response respond(const SensorChain& chain, const SensorExposure& exposure, int colour,
                 const SetNoise& noise, double signal) {
  const Moments response = effects::response_moments(chain, signal, colour, exposure);
  const double noise2 = square(noise.stated_dn);
  const double h =
      1e-3 * std::max(std::abs(signal), 1e-3 * effects::full_scale_dn(exposure.file_bits));
  const double slope = (effects::response_moments(chain, signal + h, colour, exposure).mean_dn -
                        effects::response_moments(chain, signal - h, colour, exposure).mean_dn) /
                       (2 * h);
  const double log_slope = slope * signal;
  const double read2 = square(chain.read_sigma_dn);
  const double temporal2 = response.variance_dn2 + read2;
  const double pattern2 = square(chain.pixel_gain_sigma * log_slope) +
                          square(chain.pixel_offset_sigma_dn) + square(chain.column_sigma_dn);
  const double row2 = square(chain.row_sigma_dn), all2 = temporal2 + pattern2 + row2;
  const auto file = [&](double mean, double variance) {
    return effects::file_moments(chain, {mean, variance}, exposure.file_bits);
  };
  const Moments all = file(response.mean_dn, all2);
  const double top = std::min(chain.full_dn, effects::full_scale_dn(exposure.file_bits));
  const double step = effects::quantisation_step(chain, exposure.file_bits);
  const double reach = 7 * std::sqrt(all2) + step;
  const bool clipped = response.mean_dn < reach || response.mean_dn + reach > top;
  Response out{.mean = all.mean_dn, .offset_slope = 1};
  if (!clipped && temporal2 > step * step) {
    out.variance = temporal2 + step * step / 12 + noise2;
  } else {
    // Averages over the fixed patterns, which move the value against steps and clipping.
    const double d = 0.1 * std::sqrt(all2) + 1e-3;
    out.offset_slope =
        (file(response.mean_dn + d, all2).mean_dn - file(response.mean_dn - d, all2).mean_dn) /
        (2 * d);
    out.variance =
        average(std::sqrt(pattern2 + row2), std::sqrt(temporal2 + 0.1 * step * step),
                [&](double x) { return file(response.mean_dn + x, temporal2).variance_dn2; });
    out.variance += noise2;
  }
  // No value is exactly certain: a constant field with rounding off by one.
  out.variance = std::max(out.variance, 1e-4);
  if (is_near_top(chain, exposure.file_bits, out.mean))
    out.variance = std::max(out.variance, noise.least_at_top_dn2);
  out.gain_slope = log_slope * out.offset_slope;
  if (chain.hot_fraction > 0)
    out.hot_mean = file(response.mean_dn + chain.hot_level_dn, all2).mean_dn;
  if (chain.weak_fraction > 0) {
    const Moments weak =
        effects::response_moments(chain, signal * chain.weak_gain, colour, exposure);
    out.weak_mean = file(weak.mean_dn, weak.variance_dn2 + read2 + pattern2 + row2).mean_dn;
  }
  return out;
}

ResponseTable::ResponseTable(const SensorChain& chain, const SensorExposure& exposure, int colour,
                             const SetNoise& noise, double low, double high) {
  // The noise smooths the response over its own width.
  const double own2 = effects::response_moments(chain, low, colour, exposure).variance_dn2 +
                      chain.read_sigma_dn * chain.read_sigma_dn;
  const double step =
      std::max(effects::quantisation_step(chain, exposure.file_bits), std::sqrt(own2));
  low_ = low;
  const int cells =
      high > low ? std::clamp(static_cast<int>(16 * (high - low) / step), 32, 4096) : 0;
  width_ = cells ? (high - low) / cells : 1;
  for (int i = 0; i <= cells; ++i) {
    entries_.push_back(respond(chain, exposure, colour, noise, low + i * width_));
  }
}

Response ResponseTable::at(double signal) const {
  if (entries_.size() == 1) return entries_[0];
  const double place = std::clamp((signal - low_) / width_, 0.0, entries_.size() - 1.0 - 1e-9);
  const auto i = static_cast<size_t>(place);
  const double w = place - static_cast<double>(i);
  const Response &a = entries_[i], &b = entries_[i + 1];
  const auto mix = [w](double x, double y) { return x + w * (y - x); };
  return {mix(a.mean, b.mean),
          mix(a.variance, b.variance),
          mix(a.offset_slope, b.offset_slope),
          mix(a.gain_slope, b.gain_slope),
          mix(a.hot_mean, b.hot_mean),
          mix(a.weak_mean, b.weak_mean)};
}

}  // namespace seam::measurement
