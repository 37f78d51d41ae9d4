#include "effects/proof/sensor_outcome.h"

#include "effects/stages/sensor/sensor.h"

namespace seam::effects {
namespace {

// What a filter makes of independent noise of variance 1.
struct Mixed {
  double variance = 1;  // Of a sample,
  // and its correlation with the next one of its row, of its column.
  double next_in_row = 0, next_in_column = 0;
};

// From what it makes of a single point.
Mixed mixed_point(const Mixing& weights) {
  constexpr size_t kSide = 7;
  std::vector<float> image(kSide * kSide, 0);
  image[image.size() / 2] = 1;
  mix(weights, {.width_px = kSide, .height_px = kSide}, image);
  double squares = 0, in_row = 0, in_column = 0;
  for (size_t i = 0; i + kSide < image.size(); ++i) {
    squares += image[i] * image[i];
    in_row += image[i] * image[i + 1], in_column += image[i] * image[i + kSide];
  }
  return {squares, in_row / squares, in_column / squares};
}

}  // namespace

Quantities sensor_outcome(const Model& model, const Quantities& given) {
  const SensorChain chain = sensor_of(model);
  const SensorExposure exposure{.exposure_s = value_of(given, "exposure_s", 0.01),
                                .exposure_ratio = value_of(given, "exposure_ratio", 1)};
  const double signal = signal_dn(chain, value_of(given, "light", 0.5), exposure);
  const Moments seen =
      response_moments(chain, signal, static_cast<int>(value_of(given, "channel", 1)), exposure);
  const auto square = [](double x) { return x * x; };
  const double lost = (1 - chain.weak_gain) * signal;
  const Mixed mixed = mixed_point(chain.mixing);
  return {
      {"mean_dn", seen.mean_dn},
      {"variance_dn2", mixed.variance * (seen.variance_dn2 + square(chain.read_sigma_dn))},
      {"noise_kept", mixed.variance},
      {"next_in_row", mixed.next_in_row},
      {"next_in_column", mixed.next_in_column},
      {"row_variance_dn2", square(chain.row_sigma_dn)},
      {"wave_dn", chain.wave.amplitude_dn *
                      chain.wave.unit_at(value_of(given, "u_px"), value_of(given, "v_px"))},
      {"pattern_mean_dn", chain.hot_fraction * chain.hot_level_dn - chain.weak_fraction * lost},
      {"pattern_variance_dn2",
       square(chain.pixel_gain_sigma * signal) + square(chain.pixel_offset_sigma_dn) +
           square(chain.column_sigma_dn) + square(chain.dark_sigma_dn_per_s * exposure.dark_s()) +
           chain.hot_fraction * (1 - chain.hot_fraction) * square(chain.hot_level_dn) +
           chain.weak_fraction * (1 - chain.weak_fraction) * square(lost)},
      {"file_dn", static_cast<double>(to_file(chain, value_of(given, "value_dn"), 8))}};
}

}  // namespace seam::effects
