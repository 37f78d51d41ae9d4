// The inner loops of the sensor chain: random numbers, photon noise, response, rounding.
//
// Plain loops without branches over runs of samples, in IEEE float operations alone, so that every
// vector width gives the same bits. Files that include `sensor_kernels.inc` are compiled for one
// width each; `sensor_kernels()` picks the widest that this machine has.
#pragma once

#include <cstddef>
#include <cstdint>

namespace seam::effects {

// Normals come in groups of 64 from 16 Philox blocks: sample i is lane (i % 64) / 16 of block
// 16 (i / 64) + i % 16, so that vectors of 16 blocks store side by side.
inline constexpr int kNormalGroup = 64;
inline constexpr int kNormalBlocks = 16;

// From so many electrons on, photon counts are drawn as rounded normal numbers with the Poisson
// distribution's skewness and kurtosis (Cornish-Fisher); their distribution function is then off
// by less than 1e-4. Below, they are drawn exactly.
inline constexpr float kManyElectrons = 100;

struct ReadOut {
  float sigma, full, step, top;
};

struct SensorKernels {
  // Standard normals of samples [64 first_group, 64 (first_group + groups)).
  void (*normals)(uint64_t seed, uint64_t stream, uint64_t first_group, size_t groups, float* out);
  // out[i] = illumination[i] * scale, times gain[i] where there is one.
  void (*signal)(const float* illumination, float scale, const float* gain, size_t count,
                 float* out);
  // value[i] becomes electrons (value * electrons_per_value + dark), then their random count.
  // Counts of fewer than kManyElectrons are left as their mean; returns how many there are.
  size_t (*count_electrons)(const float* normal, float electrons_per_value, float dark,
                            size_t count, float* value);
  // value[i] = value[i] * scale.
  void (*scale)(float scale, size_t count, float* value);
  // value[i] = full * (value[i] / full)^gamma, 0 for value <= 0.
  void (*gamma)(float full, float gamma, size_t count, float* value);
  // value[i] = value[i] * (1 + k2 s + k3 s^2), s = value[i] * per_full.
  void (*cubic)(float per_full, float k2, float k3, size_t count, float* value);
  // value[i] = channel_gain[i] * value[i] + black, then + offset[i] where there is one.
  void (*balance)(const float* channel_gain, float black, const float* offset, size_t count,
                  float* value);
  // value[i] += offset[i].
  void (*add)(const float* offset, size_t count, float* value);
  // value[i] + sigma * normal[i], clipped at full, rounded to multiples of the step (a power of
  // two), then to whole numbers from 0 to top.
  void (*read_out)(const float* value, const float* normal, const ReadOut& how, size_t count,
                   uint16_t* out);
  void (*read_out_bytes)(const float* value, const float* normal, const ReadOut& how, size_t count,
                         uint8_t* out);
  const char* name;
};

const SensorKernels& sensor_kernels();

}  // namespace seam::effects
