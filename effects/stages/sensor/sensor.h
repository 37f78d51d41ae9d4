// Stage `sensor`: from linear light on a pixel to the digital number in the file. One definition
// gives samples, and means and variances that agree with them.
//
//   signal    = gain_dn * illumination * exposure ratio * gain column * (1 + pixel gain)
//               * the frame's own factor of light
//   electrons = Poisson(signal * electrons_per_dn / gain column + dark_current * exposure_s)
//   value     = white_balance * cubic(gamma(electrons * gain column / electrons_per_dn))
//   value    += black + wave + pixel, column, row and hot offsets + read noise
//               + dark offsets of pixels * exposure_s
//   value     = mixed with its neighbours(min(value, full_dn)) where there is such a filter
//   value     = to the file's whole numbers(to multiples of the quantisation(min(value, full_dn)))
//
// Without shot noise there is 1 electron a DN and no photon variance. `illumination` includes
// everything before the sensor: lamps, gain fields, glare, the camera's own light.
//
// Noise: each effect draws from a stream of its own, so that changing one never changes another's.
//   fixed:     camera_noise.child(effect), index = sample, or the column
//   per frame: camera_noise.child("frame").child(frame_index).child(effect), index = sample, or row
// with sample = (v * width + u) * channels + channel. Row and column offsets are shared by
// channels. Photon and read noise of a sample are `sample_normal` of these streams
// (sensor_kernels.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/stages/sensor/mixing.h"
#include "sim_core/base/image.h"
#include "sim_core/base/random.h"

namespace seam::effects {

// What an expression effect makes of a mean at a time of the set.
struct SensorMap {
  std::string effect;
  std::function<double(double mean_dn, double t_s)> map;
  double operator()(double mean_dn, double t_s) const { return map(mean_dn, t_s); }
};

// A fixed wave over the image.
struct PatternWave {
  double amplitude_dn = 0;
  double period_px = 1;
  double angle_rad = 0;
  double phase_rad = 0;

  // The wave of amplitude 1 at a pixel.
  double unit_at(double u, double v) const;
};

// What the sensor effects of a model add up to.
struct SensorChain {
  double gain_dn = 255;  // DN for illumination 1 at the first frame's exposure.
  double black_dn = 0;
  double electrons_per_dn = std::numeric_limits<double>::infinity();  // Infinite: no photon noise.
  double dark_electrons_per_s = 0;
  double gamma = 1;
  double cubic2 = 0, cubic3 = 0;                   // Bends of the response, relative to full scale.
  std::array<double, 3> channel_gain = {1, 1, 1};  // White balance: red, green, blue.
  double pixel_gain_sigma = 0;                     // Fixed, relative (PRNU).
  double pixel_offset_sigma_dn = 0;                // Fixed (DSNU).
  double dark_sigma_dn_per_s = 0;                  // Fixed, grows with exposure (DCNU).
  double column_sigma_dn = 0;                      // Fixed.
  double row_sigma_dn = 0;                         // New for each row of each frame.
  double read_sigma_dn = 0;                        // New for each sample.
  double hot_fraction = 0;                         // Of samples; fixed.
  double hot_level_dn = 0;
  double weak_fraction = 0;  // Of samples; fixed.
  double weak_gain = 1;
  double lamp_sigma = 0;  // Of the light of a frame, relative; new for each frame.
  PatternWave wave;
  double full_dn = std::numeric_limits<double>::infinity();
  Mixing mixing;  // A filter over neighbours.
  int bits = 0;   // 0: as many as the file has.
  // Expression effects: maps of the mean, DN with black and before fixed offsets and row and read
  // noise, at a time of the set; applied in order.
  std::vector<SensorMap> maps;

  bool is_cubic() const { return cubic2 != 0 || cubic3 != 0; }
  bool has_pixel_patterns() const {
    return pixel_offset_sigma_dn > 0 || pixel_gain_sigma > 0 || dark_sigma_dn_per_s > 0;
  }
  bool has_shot_noise() const { return electrons_per_dn < std::numeric_limits<double>::infinity(); }
};

SensorChain sensor_of(const Model& model);

// One sigma whose square is a measured variance, which may have come out too small.
inline double root_at_least(double least, double variance) {
  return std::sqrt(std::max(variance, least * least));
}

// How one frame was exposed.
struct SensorExposure {
  double exposure_s = 0;
  double exposure_ratio = 1;  // exposure_s over that of the first frame (1 where that is 0).
  double gain = 1;            // The camera's gain setting (`gain` column).
  double t_s = 0;             // Set's time, for maps that depend on it.
  int file_bits = 8;
  // A map that gives no number is an error; a fit, which tries what may not work, goes on.
  bool numbers_only = false;

  // Seconds for which a pixel's dark current counts, at gain 1.
  double dark_s() const { return exposure_s * gain; }
};

struct Moments {
  double mean_dn = 0;
  double variance_dn2 = 0;
};

// DN above black that this light gives on a pixel of nominal gain.
double signal_dn(const SensorChain& chain, double illumination, const SensorExposure& exposure);

// Mean and variance over photon noise of the value after gamma, white balance, black and maps,
// before offsets and read noise. `signal` includes the pixel's own gain.
Moments response_moments(const SensorChain& chain, double signal, int channel,
                         const SensorExposure& exposure);

// Clipping, quantisation, rounding and clipping to the file.
uint16_t to_file(const SensorChain& chain, double value, int file_bits);
// Mean and variance of `to_file` of a Gaussian value.
Moments file_moments(const SensorChain& chain, Moments value, int file_bits);

// Whether no more light gives a lower value, from none to this signal, as far as the camera does
// not clip. Users' maps may do anything.
bool rises_with_light(const SensorChain& chain, double signal, int colour, int file_bits);

// The highest value of a file, to which response_cubic and clipping relate.
inline double full_scale_dn(int file_bits) {
  return static_cast<double>((1u << file_bits) - 1);
}

// Step between the values that a file holds: 2^(file bits - bits).
double quantisation_step(const SensorChain& chain, int file_bits);

// A camera's fixed patterns, drawn once.
struct FixedPattern {
  int width_px = 0;
  int height_px = 0;
  int channels = 1;
  std::vector<float> gain;  // 1 + PRNU, a factor for each sample.
  std::vector<float>
      offset_dn;  // Wave, pixel, column and hot offsets for each sample (without black).
  std::vector<float> dark_dn_per_s;  // Of each sample, at gain 1; empty: none.
  // False where all gains are 1, all offsets 0: what need not be looked at.
  bool has_gain = true, has_offset = true;
};
FixedPattern fixed_pattern(const SensorChain& chain, int width_px, int height_px, int channels,
                           RandomStream camera_noise);

// The standard normal that read noise, photon noise and fixed patterns draw for a sample.
float sample_normal(RandomStream stream, uint64_t sample);
// Those of samples 0, 1, 2, ...
void sample_normals(RandomStream stream, std::span<float> out);

// The stream of the read-out's noise, one normal number a sample.
inline RandomStream read_noise_stream(RandomStream frame_noise) {
  return frame_noise.child("read_noise");
}

// One frame: `illumination` has width * height * channels values, row-major, interleaved. With one
// channel the white balance's gain of green (1) applies. `noise` false: means without any noise or
// fixed pattern, rounded to the file.
Image expose(const SensorChain& chain, const FixedPattern& pattern,
             std::span<const float> illumination, const SensorExposure& exposure,
             RandomStream frame_noise, bool noise = true);

// Illumination as it is needed: that of `count` samples from `first` on, valid until the next call;
// each call goes on where the one before ended.
using LightSource = std::function<const float*(size_t first, size_t count)>;

// The same with noise for files of 8 bits, straight into bytes.
void expose_bytes(const SensorChain& chain, const FixedPattern& pattern, const LightSource& light,
                  const SensorExposure& exposure, RandomStream frame_noise, std::span<uint8_t> out);

}  // namespace seam::effects
