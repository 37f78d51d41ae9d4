// What a sensor makes of a signal in the file: mean, variance in time and the weights of fixed
// patterns, tabulated over the signals of an image.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <vector>

#include "effects/stages/sensor/sensor.h"

namespace seam::measurement {

struct Response {
  double mean = 0;          // DN, averaged over fixed patterns and row noise.
  double variance = 0;      // Of one value in time without row noise, DN^2; with rounding.
  double offset_slope = 0;  // d mean / d offset: 1, less near clipping.
  double gain_slope = 0;    // d mean / d log(signal), DN.
  double hot_mean = 0;      // Mean of a hot sample.
  double weak_mean = 0;     // Mean of a sample of low gain.
};

// From `a` (at 0) to `b` (at 1).
inline Response between(const Response& a, const Response& b, double at) {
  const auto mix = [at](double x, double y) { return x + at * (y - x); };
  return {mix(a.mean, b.mean),
          mix(a.variance, b.variance),
          mix(a.offset_slope, b.offset_slope),
          mix(a.gain_slope, b.gain_slope),
          mix(a.hot_mean, b.hot_mean),
          mix(a.weak_mean, b.weak_mean)};
}

// What a set says of the noise of its values, whatever the model is.
struct SetNoise {
  double stated_dn = 0;
  // Where values are clipped at the highest, a few that are not make all of the variance, so that
  // it is not told as well as that of Gaussian values: it is this at least.
  double least_at_top_dn2 = 0;
  // The same where most values are cut off at 0.
  double least_at_bottom_dn2 = 0;
};

// Whether it is this end of the range where a value so large is clipped.
bool is_near_top(const effects::SensorChain& chain, int file_bits, double dn);

// For a signal (effects::signal_dn) beside a fixed offset of the pixels; `colour` 0 red, 1 green,
// 2 blue.
Response respond(const effects::SensorChain& chain, const effects::SensorExposure& exposure,
                 int colour, const SetNoise& noise, double signal, double offset_dn = 0);

// Responses without a signal, which are dear where values are cut off at 0 and the same for all
// dark levels and for all that acts on light. Thread-safe.
class DarkResponses {
 public:
  Response of(const effects::SensorChain& chain, const effects::SensorExposure& exposure,
              int colour, const SetNoise& noise, double offset_dn) const;

 private:
  using Key = std::array<double, 18>;
  mutable std::mutex mutex_;
  mutable std::map<Key, Response> known_;
};

// Whether the fixed wave over the image leads below the file's range for such a signal, so that it
// is no longer in the values what it was before. (Values that are clipped at the top say little.)
bool is_wave_cut(const effects::SensorChain& chain, const effects::SensorExposure& exposure,
                 double signal);

class ResponseTable {
 public:
  // For signals (effects::signal_dn) from `low` to `high`; `colour` 0 red, 1 green, 2 blue.
  ResponseTable(const effects::SensorChain& chain, const effects::SensorExposure& exposure,
                int colour, const SetNoise& noise, double low, double high, double offset_dn = 0);
  // Responses that such a table works out.
  static size_t size_for(const effects::SensorChain& chain, const effects::SensorExposure& exposure,
                         int colour, double low, double high);

  // Here, since every sample of every image asks, and few ask for all of it.
  Response at(double signal) const {
    if (entries_.size() == 1) return entries_[0];
    const double last = static_cast<double>(entries_.size() - 1);
    const double place = std::clamp((signal - low_) / width_, 0.0, last - 1e-9);
    const auto i = static_cast<size_t>(place);
    return between(entries_[i], entries_[i + 1], place - static_cast<double>(i));
  }

 private:
  double low_ = 0, width_ = 1;
  std::vector<Response> entries_;
};

}  // namespace seam::measurement
