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

// d mean / d log(signal) before fixed patterns and clipping.
double log_slope_of(const SensorChain& chain, const SensorExposure& exposure, int colour,
                    double signal) {
  const double h =
      1e-3 * std::max(std::abs(signal), 1e-3 * effects::full_scale_dn(exposure.file_bits));
  const double slope = (effects::response_moments(chain, signal + h, colour, exposure).mean_dn -
                        effects::response_moments(chain, signal - h, colour, exposure).mean_dn) /
                       (2 * h);
  return slope * signal;
}

}  // namespace

bool is_near_top(const SensorChain& chain, int file_bits, double dn) {
  return dn > 0.5 * std::min(chain.full_dn, effects::full_scale_dn(file_bits));
}

Response respond(const SensorChain& chain, const SensorExposure& exposure, int colour,
                 const SetNoise& noise, double signal, double offset_dn) {
  Moments response = effects::response_moments(chain, signal, colour, exposure);
  response.mean_dn += offset_dn;
  const double noise2 = square(noise.stated_dn);
  const double log_slope = log_slope_of(chain, exposure, colour, signal);
  const double read2 = square(chain.read_sigma_dn);
  const double temporal2 = response.variance_dn2 + read2;
  const double pattern2 =
      square(chain.pixel_gain_sigma * log_slope) + square(chain.pixel_offset_sigma_dn) +
      square(chain.dark_sigma_dn_per_s * exposure.dark_s()) + square(chain.column_sigma_dn);
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
  constexpr double kCertain = 1e-4;
  out.variance = std::max(out.variance, kCertain);
  // A value that is cut off has no more noise than the model gives one that is not: else a model
  // without noise is likeliest where it sends all values to an end of the range.
  const double uncut = std::max(all2 + noise2, kCertain);
  if (is_near_top(chain, exposure.file_bits, out.mean))
    out.variance = std::max(out.variance, std::min(noise.least_at_top_dn2, uncut));
  if (response.mean_dn < 0)
    out.variance = std::max(out.variance, std::min(noise.least_at_bottom_dn2, uncut));
  out.gain_slope = log_slope * out.offset_slope;
  if (chain.hot_fraction > 0)
    out.hot_mean = file(response.mean_dn + chain.hot_level_dn, all2).mean_dn;
  if (chain.weak_fraction > 0) {
    const Moments weak =
        effects::response_moments(chain, signal * chain.weak_gain, colour, exposure);
    out.weak_mean =
        file(weak.mean_dn + offset_dn, weak.variance_dn2 + read2 + pattern2 + row2).mean_dn;
  }
  return out;
}

bool is_wave_cut(const SensorChain& chain, const SensorExposure& exposure, double signal) {
  if (!(chain.wave.amplitude_dn > 0)) return false;
  constexpr double kReach = 3;  // Standard deviations.
  const Moments at = effects::response_moments(chain, signal, 1, exposure);
  const double sigma = std::sqrt(at.variance_dn2 + square(chain.read_sigma_dn) +
                                 square(chain.pixel_offset_sigma_dn) +
                                 square(chain.dark_sigma_dn_per_s * exposure.dark_s()) +
                                 square(chain.column_sigma_dn) + square(chain.row_sigma_dn));
  return at.mean_dn < chain.wave.amplitude_dn + kReach * sigma;
}

Response DarkResponses::of(const SensorChain& chain, const SensorExposure& exposure, int colour,
                           const SetNoise& noise, double offset_dn) const {
  constexpr size_t kMost = 20'000;
  const Moments dark = effects::response_moments(chain, 0, colour, exposure);
  // All that `respond` asks of a chain without a signal.
  const Key key = {dark.mean_dn,
                   dark.variance_dn2,
                   log_slope_of(chain, exposure, colour, 0),
                   offset_dn,
                   chain.read_sigma_dn,
                   chain.pixel_offset_sigma_dn,
                   chain.dark_sigma_dn_per_s * exposure.dark_s(),
                   chain.column_sigma_dn,
                   chain.row_sigma_dn,
                   chain.full_dn,
                   static_cast<double>(chain.bits),
                   static_cast<double>(exposure.file_bits),
                   noise.stated_dn,
                   noise.least_at_top_dn2,
                   noise.least_at_bottom_dn2,
                   chain.hot_fraction,
                   chain.hot_level_dn,
                   chain.weak_fraction};
  if (std::any_of(key.begin(), key.end(), [](double x) { return std::isnan(x); }))
    return respond(chain, exposure, colour, noise, 0, offset_dn);
  {
    const std::scoped_lock lock(mutex_);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
  }
  const Response own = respond(chain, exposure, colour, noise, 0, offset_dn);
  const std::scoped_lock lock(mutex_);
  if (known_.size() >= kMost) known_.clear();
  known_.emplace(key, own);
  return own;
}

size_t ResponseTable::size_for(const SensorChain& chain, const SensorExposure& exposure, int colour,
                               double low, double high) {
  if (!(high > low)) return 1;
  // The noise smooths the response over its own width.
  const double own2 = effects::response_moments(chain, low, colour, exposure).variance_dn2 +
                      chain.read_sigma_dn * chain.read_sigma_dn;
  const double step =
      std::max(effects::quantisation_step(chain, exposure.file_bits), std::sqrt(own2));
  return 1 + std::clamp<size_t>(static_cast<size_t>(std::min(16 * (high - low) / step, 4096.0)), 4,
                                4096);
}

ResponseTable::ResponseTable(const SensorChain& chain, const SensorExposure& exposure, int colour,
                             const SetNoise& noise, double low, double high, double offset_dn) {
  low_ = low;
  const int cells = static_cast<int>(size_for(chain, exposure, colour, low, high)) - 1;
  width_ = cells ? (high - low) / cells : 1;
  for (int i = 0; i <= cells; ++i) {
    entries_.push_back(respond(chain, exposure, colour, noise, low + i * width_, offset_dn));
  }
}

}  // namespace seam::measurement
