// Samples of the sensor chain, by vector kernels: chunks of a frame pass through them while they
// are in the processor's first cache.
#include <algorithm>
#include <cmath>

#include "effects/not_a_number.h"
#include "effects/stages/sensor/sensor.h"
#include "effects/stages/sensor/sensor_kernels.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

// Whole groups of normals, and whole pixels of three channels.
constexpr size_t kChunk = 3 * 8 * kNormalGroup;

int colour_of(size_t sample, int channels) {
  return channels == 1 ? 1 : static_cast<int>(sample % static_cast<size_t>(channels));
}

// What a chunk works with; `first` is its first sample in the frame, a multiple of kNormalGroup.
struct Chunk {
  size_t first = 0;
  size_t count = 0;
  std::vector<float> value = std::vector<float>(kChunk);
  std::vector<float> scratch = std::vector<float>(kChunk);

  const float* normals_of(const SensorKernels& kernels, RandomStream stream) {
    kernels.normals(stream.seed, stream.stream, first / kNormalGroup,
                    (count + kNormalGroup - 1) / kNormalGroup, scratch.data());
    return scratch.data();
  }
};

class Exposing {
 public:
  Exposing(const SensorChain& chain, const FixedPattern& pattern, const SensorExposure& exposure,
           RandomStream frame_noise)
      : kernels_(sensor_kernels()),
        chain_(chain),
        pattern_(pattern),
        exposure_(exposure),
        shot_(frame_noise.child("shot_noise")),
        few_(shot_.child("few")),
        row_(frame_noise.child("row_noise")),
        read_(read_noise_stream(frame_noise)),
        lamp_(chain.lamp_sigma > 0
                  ? std::max(0.0, 1 + chain.lamp_sigma *
                                          normal(frame_noise.child("lamp_fluctuation"), 0))
                  : 1),
        channel_gain_(kChunk),
        offset_(pattern.dark_dn_per_s.empty() ? 0 : kChunk) {
    // A chunk begins with a whole pixel.
    for (size_t i = 0; i < kChunk; i += 3) {
      for (int c = 0; c < 3; ++c)
        channel_gain_[i + c] =
            static_cast<float>(chain.channel_gain[pattern.channels == 1 ? 1 : c]);
    }
  }

  // A whole frame.
  template <typename Light, typename Sample>
  void expose_all(const Light& light, std::span<Sample> out) {
    if (chain_.mixing.acts()) return expose_mixed(light, out);
    Chunk chunk;
    for (; chunk.first < out.size(); chunk.first += kChunk) {
      chunk.count = std::min(kChunk, out.size() - chunk.first);
      expose(chunk, light(chunk.first, chunk.count));
      read_out(chunk, &out[chunk.first]);
    }
  }

 private:
  // A whole frame whose samples are mixed before they are rounded.
  template <typename Light, typename Sample>
  void expose_mixed(const Light& light, std::span<Sample> out) {
    std::vector<float> whole(out.size());
    const auto full = static_cast<float>(std::min(chain_.full_dn, 1e30));
    const auto sigma = static_cast<float>(chain_.read_sigma_dn);
    Chunk chunk;
    for (; chunk.first < out.size(); chunk.first += kChunk) {
      chunk.count = std::min(kChunk, out.size() - chunk.first);
      expose(chunk, light(chunk.first, chunk.count));
      const float* const normal = sigma > 0 ? chunk.normals_of(kernels_, read_) : nullptr;
      for (size_t i = 0; i < chunk.count; ++i) {
        const float read = normal != nullptr ? sigma * normal[i] : 0;
        whole[chunk.first + i] = std::min(chunk.value[i] + read, full);
      }
    }
    mix(chain_.mixing, {pattern_.width_px, pattern_.height_px, pattern_.channels}, whole);
    for (size_t i = 0; i < out.size(); ++i)
      out[i] = static_cast<Sample>(to_file(chain_, whole[i], exposure_.file_bits));
  }

  // Up to the noise of reading.
  void expose(Chunk& chunk, const float* illumination) {
    count_light(chunk, illumination);
    float* value = chunk.value.data();
    if (chain_.gamma != 1) {
      kernels_.gamma(static_cast<float>(chain_.gain_dn), static_cast<float>(chain_.gamma),
                     chunk.count, value);
    }
    if (chain_.is_cubic()) {
      kernels_.cubic(static_cast<float>(1 / full_scale_dn(exposure_.file_bits)),
                     static_cast<float>(chain_.cubic2), static_cast<float>(chain_.cubic3),
                     chunk.count, value);
    }
    const auto black = static_cast<float>(chain_.black_dn);
    const float* const offset = offsets_of(chunk);
    if (chain_.maps.empty()) {
      kernels_.balance(channel_gain_.data(), black, offset, chunk.count, value);
    } else {
      kernels_.balance(channel_gain_.data(), black, nullptr, chunk.count, value);
      for (const auto& map : chain_.maps) {
        for (size_t i = 0; i < chunk.count; ++i) {
          const double mapped = map(value[i], exposure_.t_s);
          if (exposure_.numbers_only && !usable(mapped, kLargestOfImage)) {
            fail_with(map.effect, "mean", mapped,
                      fmt::format("a sample of {:g} DN at {:.9g} s", value[i], exposure_.t_s));
          }
          value[i] = static_cast<float>(mapped);
        }
      }
      if (offset != nullptr) kernels_.add(offset, chunk.count, value);
    }
    if (chain_.row_sigma_dn > 0) add_row_noise(chunk);
  }

  // Fixed offsets of a chunk's samples, with what their dark currents have grown to.
  const float* offsets_of(const Chunk& chunk) {
    if (pattern_.dark_dn_per_s.empty())
      return pattern_.has_offset ? &pattern_.offset_dn[chunk.first] : nullptr;
    const auto dark_s = static_cast<float>(exposure_.dark_s());
    for (size_t i = 0; i < chunk.count; ++i) {
      offset_[i] =
          pattern_.offset_dn[chunk.first + i] + dark_s * pattern_.dark_dn_per_s[chunk.first + i];
    }
    return offset_.data();
  }

  template <typename Sample>
  void read_out(Chunk& chunk, Sample* out) {
    const ReadOut how{.sigma = static_cast<float>(chain_.read_sigma_dn),
                      .full = static_cast<float>(std::min(chain_.full_dn, 1e30)),
                      .step = static_cast<float>(quantisation_step(chain_, exposure_.file_bits)),
                      .top = static_cast<float>(full_scale_dn(exposure_.file_bits))};
    // Without noise of reading, numbers that stand there already count 0 times.
    const float* normal = how.sigma > 0 ? chunk.normals_of(kernels_, read_) : chunk.scratch.data();
    if constexpr (sizeof(Sample) == 1) {
      kernels_.read_out_bytes(chunk.value.data(), normal, how, chunk.count, out);
    } else {
      kernels_.read_out(chunk.value.data(), normal, how, chunk.count, out);
    }
  }

  // Light to signal, DN above black, with photon noise.
  void count_light(Chunk& chunk, const float* illumination) {
    const auto scale = static_cast<float>(signal_dn(chain_, lamp_, exposure_));
    float* value = chunk.value.data();
    kernels_.signal(illumination, scale, pattern_.has_gain ? &pattern_.gain[chunk.first] : nullptr,
                    chunk.count, value);
    const double dark = chain_.dark_electrons_per_s * exposure_.exposure_s;
    if (!chain_.has_shot_noise()) {
      if (dark > 0) {
        const auto lift = static_cast<float>(dark * exposure_.gain);
        for (size_t i = 0; i < chunk.count; ++i) value[i] += lift;
      }
      return;
    }
    const float* normal = chunk.normals_of(kernels_, shot_);
    const auto electrons = static_cast<float>(chain_.electrons_per_dn / exposure_.gain);
    const size_t few =
        kernels_.count_electrons(normal, electrons, static_cast<float>(dark), chunk.count, value);
    if (few > 0) {
      for (size_t i = 0; i < chunk.count; ++i) {
        // Counts of the others are whole numbers of at least kManyElectrons - 7
        // sqrt(kManyElectrons); whether a sample is one of the few depends on its mean alone.
        const float mean =
            std::max(illumination[i] * scale * pattern_.gain[chunk.first + i] * electrons +
                         static_cast<float>(dark),
                     0.0f);
        if (mean < kManyElectrons)
          value[i] = static_cast<float>(poisson(few_, chunk.first + i, mean));
      }
    }
    kernels_.scale(static_cast<float>(exposure_.gain / chain_.electrons_per_dn), chunk.count,
                   value);
  }

  void add_row_noise(Chunk& chunk) {
    const size_t row_samples = static_cast<size_t>(pattern_.width_px) * pattern_.channels;
    for (size_t i = 0; i < chunk.count;) {
      const size_t row = (chunk.first + i) / row_samples;
      const auto offset = static_cast<float>(chain_.row_sigma_dn * normal(row_, row));
      const size_t end = std::min(chunk.count, (row + 1) * row_samples - chunk.first);
      for (; i < end; ++i) chunk.value[i] += offset;
    }
  }

  const SensorKernels& kernels_;
  const SensorChain& chain_;
  const FixedPattern& pattern_;
  const SensorExposure& exposure_;
  RandomStream shot_, few_, row_, read_;
  double lamp_;  // The frame's own factor of light.
  std::vector<float> channel_gain_, offset_;
};

}  // namespace

float sample_normal(RandomStream stream, uint64_t sample) {
  float group[kNormalGroup];
  sensor_kernels().normals(stream.seed, stream.stream, sample / kNormalGroup, 1, group);
  return group[sample % kNormalGroup];
}

void sample_normals(RandomStream stream, std::span<float> out) {
  const size_t whole = out.size() / kNormalGroup;
  sensor_kernels().normals(stream.seed, stream.stream, 0, whole, out.data());
  for (size_t i = whole * kNormalGroup; i < out.size(); ++i) out[i] = sample_normal(stream, i);
}

Image expose(const SensorChain& chain, const FixedPattern& pattern,
             std::span<const float> illumination, const SensorExposure& exposure,
             RandomStream frame_noise, bool noise) {
  Image image{.width_px = pattern.width_px,
              .height_px = pattern.height_px,
              .channels = pattern.channels,
              .bits = exposure.file_bits};
  SEAM_CHECK(illumination.size() == pattern.gain.size(), "{}", illumination.size());
  image.samples.resize(illumination.size());
  if (!noise) {
    const auto mean_of = [&](size_t i) {
      const double signal = signal_dn(chain, illumination[i], exposure);
      return response_moments(chain, signal, colour_of(i, pattern.channels), exposure).mean_dn;
    };
    std::vector<float> mixed(chain.mixing.acts() ? illumination.size() : 0);
    for (size_t i = 0; i < mixed.size(); ++i)
      mixed[i] = static_cast<float>(std::min(mean_of(i), chain.full_dn));
    if (!mixed.empty())
      mix(chain.mixing, {pattern.width_px, pattern.height_px, pattern.channels}, mixed);
    for (size_t i = 0; i < illumination.size(); ++i)
      image.samples[i] = to_file(chain, mixed.empty() ? mean_of(i) : mixed[i], exposure.file_bits);
    return image;
  }
  Exposing(chain, pattern, exposure, frame_noise)
      .expose_all([&](size_t first, size_t) { return &illumination[first]; },
                  std::span(image.samples));
  return image;
}

void expose_bytes(const SensorChain& chain, const FixedPattern& pattern, const LightSource& light,
                  const SensorExposure& exposure, RandomStream frame_noise,
                  std::span<uint8_t> out) {
  SEAM_CHECK(exposure.file_bits == 8 && out.size() == pattern.gain.size(), "{} bits, {} samples",
             exposure.file_bits, out.size());
  Exposing(chain, pattern, exposure, frame_noise).expose_all(light, out);
}

}  // namespace seam::effects
