#include "effects/stages/sensor/sensor.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

double to_power(const SensorChain& chain, double signal) {
  if (chain.gamma == 1) return signal;
  return signal > 0 ? chain.gain_dn * maths::pow(signal / chain.gain_dn, chain.gamma) : 0;
}

double bend(const SensorChain& chain, double value, int file_bits) {
  const double s = value / full_scale_dn(file_bits);
  return value * (1 + s * (chain.cubic2 + s * chain.cubic3));
}

// Gamma, cubic, white balance, black and maps of a signal after photon noise.
double respond(const SensorChain& chain, double signal, int colour,
               const SensorExposure& exposure) {
  double value = to_power(chain, signal);
  if (chain.is_cubic()) value = bend(chain, value, exposure.file_bits);
  value = chain.channel_gain[static_cast<size_t>(colour)] * value + chain.black_dn;
  for (const auto& map : chain.maps) value = map(value, exposure.t_s);
  return value;
}

bool response_is_linear(const SensorChain& chain) {
  return chain.gamma == 1 && !chain.is_cubic() && chain.maps.empty();
}

// E and variance of f(X) for X Poisson with mean lambda.
template <typename F>
Moments poisson_expectation(double lambda, F&& f) {
  double sum = 0, sum1 = 0, sum2 = 0;
  const auto add = [&](double weight, double value) {
    sum += weight;
    sum1 += weight * value;
    sum2 += weight * value * value;
  };
  if (lambda < 40) {
    double weight = maths::exp(-lambda);
    const int last = static_cast<int>(lambda + 12 * std::sqrt(lambda) + 12);
    for (int k = 0; k <= last; ++k) {
      add(weight, f(k));
      weight *= lambda / (k + 1);
    }
  } else {
    // Gauss-Hermite with 7 nodes over the normal approximation, skewness by Cornish-Fisher.
    static constexpr double kNodes[] = {0, 1.154405394739968, 2.366759410734541, 3.750439717725742};
    static constexpr double kWeights[] = {0.457142857142857, 0.240123178605013, 0.030757123967586,
                                          0.000548268855972};
    const double root = std::sqrt(lambda);
    for (int i = 0; i < 4; ++i) {
      for (int sign = -1; sign <= (i ? 1 : -1); sign += 2) {
        const double z = sign * kNodes[i];
        add(kWeights[i], f(lambda + root * (z + (z * z - 1) / (6 * root))));
      }
    }
  }
  const double mean = sum1 / sum;
  return {mean, std::max(0.0, sum2 / sum - mean * mean)};
}

void add_defects_of_gain(const SensorChain& chain, RandomStream camera_noise,
                         FixedPattern& pattern) {
  if (!(chain.weak_fraction > 0)) return;
  const RandomStream stream = camera_noise.child("weak_pixels");
  for (size_t i = 0; i < pattern.gain.size(); ++i) {
    if (uniform(stream, i) < chain.weak_fraction)
      pattern.gain[i] *= static_cast<float>(chain.weak_gain);
  }
}

void add_wave(const SensorChain& chain, FixedPattern& pattern) {
  if (!(chain.wave.amplitude_dn > 0)) return;
  size_t i = 0;
  for (int v = 0; v < pattern.height_px; ++v) {
    for (int u = 0; u < pattern.width_px; ++u) {
      const auto here = static_cast<float>(chain.wave.amplitude_dn * chain.wave.unit_at(u, v));
      for (int c = 0; c < pattern.channels; ++c) pattern.offset_dn[i++] += here;
    }
  }
}

}  // namespace

SensorChain sensor_of(const Model& model) {
  SensorChain chain;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->sensor) effect.definition->sensor(effect.values(), chain);
  }
  return chain;
}

double signal_dn(const SensorChain& chain, double illumination, const SensorExposure& exposure) {
  return chain.gain_dn * illumination * exposure.exposure_ratio * exposure.gain;
}

Moments response_moments(const SensorChain& chain, double signal, int channel,
                         const SensorExposure& exposure) {
  const double dark = chain.dark_electrons_per_s * exposure.exposure_s;
  if (!chain.has_shot_noise()) {
    return {respond(chain, signal + dark * exposure.gain, channel, exposure), 0};
  }
  const double dn_per_electron = exposure.gain / chain.electrons_per_dn;
  const double electrons = std::max(0.0, signal / dn_per_electron + dark);
  if (response_is_linear(chain)) {
    const double scale = chain.channel_gain[static_cast<size_t>(channel)] * dn_per_electron;
    return {scale * electrons + chain.black_dn, scale * scale * electrons};
  }
  return poisson_expectation(electrons, [&](double counted) {
    return respond(chain, counted * dn_per_electron, channel, exposure);
  });
}

bool rises_with_light(const SensorChain& chain, double signal, int colour, int file_bits) {
  if (!chain.is_cubic()) return true;
  const double brightest = to_power(chain, signal), full = full_scale_dn(file_bits);
  // Between the places where 1 + 2 k2 s + 3 k3 s^2 is zero the response only rises or only falls.
  std::vector<double> places;
  const double root = std::sqrt(chain.cubic2 * chain.cubic2 - 3 * chain.cubic3);
  for (const double s : {-1 / (chain.cubic2 - root), -1 / (chain.cubic2 + root)}) {
    if (s > 0 && s * full < brightest) places.push_back(s * full);
  }
  std::sort(places.begin(), places.end());
  places.push_back(brightest);
  double before = std::min(chain.black_dn, chain.full_dn);
  for (const double place : places) {
    const double value =
        chain.channel_gain[static_cast<size_t>(colour)] * bend(chain, place, file_bits) +
        chain.black_dn;
    const double clipped = std::min({value, chain.full_dn, full});
    if (clipped < before) return false;
    before = clipped;
  }
  return true;
}

double quantisation_step(const SensorChain& chain, int file_bits) {
  if (chain.bits <= 0 || chain.bits >= file_bits) return 1;
  return static_cast<double>(1u << (file_bits - chain.bits));
}

uint16_t to_file(const SensorChain& chain, double value, int file_bits) {
  const double step = quantisation_step(chain, file_bits);
  const double top = full_scale_dn(file_bits);
  const double clipped = std::min(value, chain.full_dn);
  // Rounded to multiples of the step, then (for a full_dn of the file's own) to whole numbers.
  const double stepped = step * std::floor(clipped / step + 0.5);
  return static_cast<uint16_t>(std::clamp(std::floor(stepped + 0.5), 0.0, top));
}

double PatternWave::unit_at(double u, double v) const {
  const double along = u * maths::cos(angle_rad) + v * maths::sin(angle_rad);
  return maths::sin(2 * maths::kPi * along / period_px + phase_rad);
}

FixedPattern fixed_pattern(const SensorChain& chain, int width_px, int height_px, int channels,
                           RandomStream camera_noise) {
  FixedPattern pattern{.width_px = width_px, .height_px = height_px, .channels = channels};
  const auto samples = static_cast<size_t>(width_px) * height_px * channels;
  pattern.gain.assign(samples, 1.0f);
  pattern.offset_dn.assign(samples, 0.0f);
  pattern.has_gain = chain.pixel_gain_sigma > 0 || chain.weak_fraction > 0;
  pattern.has_offset = chain.pixel_offset_sigma_dn > 0 || chain.column_sigma_dn > 0 ||
                       chain.hot_fraction > 0 || chain.wave.amplitude_dn > 0;
  if (chain.pixel_gain_sigma > 0) {
    sample_normals(camera_noise.child("pixel_gain_spread"), pattern.gain);
    // A gain below zero has no meaning.
    for (float& gain : pattern.gain)
      gain = static_cast<float>(std::max(0.0, 1 + chain.pixel_gain_sigma * gain));
  }
  if (chain.pixel_offset_sigma_dn > 0) {
    sample_normals(camera_noise.child("pixel_offset_spread"), pattern.offset_dn);
    for (float& offset : pattern.offset_dn)
      offset = static_cast<float>(chain.pixel_offset_sigma_dn * offset);
  }
  if (chain.dark_sigma_dn_per_s > 0) {
    pattern.dark_dn_per_s.resize(samples);
    sample_normals(camera_noise.child("dark_current_spread"), pattern.dark_dn_per_s);
    for (float& dark : pattern.dark_dn_per_s)
      dark = static_cast<float>(chain.dark_sigma_dn_per_s * dark);
  }
  if (chain.column_sigma_dn > 0) {
    std::vector<float> columns(static_cast<size_t>(width_px));
    sample_normals(camera_noise.child("column_offsets"), columns);
    for (size_t i = 0; i < samples; ++i) {
      const size_t column = i / static_cast<size_t>(channels) % static_cast<size_t>(width_px);
      pattern.offset_dn[i] += static_cast<float>(chain.column_sigma_dn * columns[column]);
    }
  }
  if (chain.hot_fraction > 0) {
    const RandomStream stream = camera_noise.child("hot_pixels");
    for (size_t i = 0; i < samples; ++i) {
      if (uniform(stream, i) < chain.hot_fraction)
        pattern.offset_dn[i] += static_cast<float>(chain.hot_level_dn);
    }
  }
  add_defects_of_gain(chain, camera_noise, pattern);
  add_wave(chain, pattern);
  return pattern;
}

}  // namespace seam::effects
