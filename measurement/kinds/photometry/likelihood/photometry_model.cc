#include "measurement/kinds/photometry/likelihood/photometry_model.h"

#include <algorithm>
#include <cmath>

#include "effects/stages/optics.h"
#include "effects/stages/timing.h"
#include "measurement/imaging/sensor_response.h"

namespace seam::measurement {
namespace {

using effects::Moments;
using effects::SensorChain;
using effects::SensorExposure;

constexpr size_t kWaveHeights = 64;

class LevelPredictor {
 public:
  LevelPredictor(const PhotometryData& data, const effects::Model& model, const SensorChain& chain,
                 const std::vector<double>& own_light, const std::vector<double>& wave,
                 const PhotometryLevel& level, const LevelSums& sum, double set_noise_dn)
      : data_(data),
        model_(model),
        chain_(chain),
        own_light_(own_light),
        wave_(wave),
        level_(level),
        sum_(sum),
        noise_{set_noise_dn, data.least_at_top_dn2, data.least_at_bottom_dn2} {
    for (const int frame : sum.frames)
      mean_time_ += time_of(frame) / static_cast<double>(sum.frames.size());
  }

  LevelPrediction run(const std::vector<double>& light, bool moving_light) {
    std::vector<std::vector<double>> lamps;
    if (effects::lamps_flicker(model_)) {
      for (const int frame : sum_.frames)
        lamps.push_back(lamp_rows(data_, frame, level_.exposure_s, model_));
    }
    std::vector<double> row_light(data_.height_px, 1);
    for (int v = 0; v < data_.height_px && !lamps.empty(); ++v) {
      double mean = 0;
      for (const auto& frame : lamps) mean += frame[v];
      row_light[v] = mean / static_cast<double>(lamps.size());
    }
    const bool blank = std::isnan(level_.illumination);
    LevelPrediction out;
    out.illumination = level_.illumination;
    if (blank) {
      out.illumination = first_guess();
      for (int step = 0; step < 4; ++step) {
        fill(out, light, row_light);
        correct_illumination(out, step == 3);
      }
    } else {
      fill(out, light, row_light);
    }
    shift_rows(out, lamps, row_light);
    if (moving_light) drift_rows(out);
    return out;
  }

 private:
  double time_of(int frame) const { return data_.frames[frame].time_s - data_.frames[0].time_s; }
  SensorExposure exposure(double t_s) const {
    return {.exposure_s = level_.exposure_s,
            .exposure_ratio = level_.exposure_ratio,
            .gain = level_.gain,
            .t_s = t_s,
            .file_bits = data_.file_bits};
  }

  double first_guess() const {
    double mean = 0;
    for (const double value : sum_.mean) mean += value;
    mean /= static_cast<double>(sum_.mean.size());
    const double per_light = effects::signal_dn(chain_, 1, exposure(0));
    return std::max(1e-6, (mean - chain_.black_dn) / per_light);
  }

  void fill(LevelPrediction& out, const std::vector<double>& light,
            const std::vector<double>& row_light) {
    const size_t samples = data_.samples();
    const double scale = effects::signal_dn(chain_, out.illumination, exposure(0));
    own_scale_ = effects::signal_dn(chain_, 1, exposure(0));
    for (auto* v : {&out.mean, &out.variance, &out.offset_slope, &out.gain_slope})
      v->resize(samples);
    if (chain_.hot_fraction > 0) out.hot_mean.resize(samples);
    if (chain_.weak_fraction > 0) out.weak_mean.resize(samples);
    if (!own_light_.empty()) out.lit_part.resize(samples);
    out.falls = false;
    const bool is_cut = is_wave_cut(chain_, exposure(mean_time_), scale);
    const auto channels = static_cast<size_t>(data_.channels);
    const size_t row_samples = data_.width_px * channels;
    const auto signal_of = [&](size_t i) {
      return scale * light[i] * row_light[i / row_samples] + own_signal(i);
    };
    for (size_t c = 0; c < channels; ++c) {
      double low = 1e300, high = -1e300;
      for (size_t i = c; i < samples; i += channels)
        low = std::min(low, signal_of(i)), high = std::max(high, signal_of(i));
      const int colour = data_.colour(static_cast<int>(c));
      out.falls = out.falls || !effects::rises_with_light(chain_, high, colour, data_.file_bits);
      const std::vector<ResponseTable> tables = tables_for(colour, low, high, is_cut);
      for (size_t i = c; i < samples; i += channels) {
        const double signal = signal_of(i);
        const Response response =
            tables.empty() ? respond(chain_, exposure(mean_time_), colour, noise_, signal,
                                     is_cut ? chain_.wave.amplitude_dn * unit_wave(i) : 0)
            : is_cut       ? beside_wave(tables, i, signal)
                           : tables[0].at(signal);
        out.mean[i] = response.mean;
        out.variance[i] = response.variance;
        out.offset_slope[i] = response.offset_slope;
        out.gain_slope[i] = response.gain_slope;
        if (!own_light_.empty()) out.lit_part[i] = signal > 0 ? 1 - own_signal(i) / signal : 1;
        if (chain_.hot_fraction > 0) out.hot_mean[i] = response.hot_mean;
        if (chain_.weak_fraction > 0) out.weak_mean[i] = response.weak_mean;
      }
    }
    if (!is_cut) add_wave(out);
  }

  // By height of the wave where it is cut off. None where there are fewer samples to ask.
  std::vector<ResponseTable> tables_for(int colour, double low, double high, bool is_cut) const {
    const size_t heights = is_cut ? kWaveHeights + 1 : 1;
    const size_t entries = ResponseTable::size_for(chain_, exposure(mean_time_), colour, low, high);
    if (heights * entries > data_.samples() / static_cast<size_t>(data_.channels)) return {};
    std::vector<ResponseTable> tables;
    for (size_t h = 0; h < heights; ++h) {
      const double wave_dn =
          is_cut ? chain_.wave.amplitude_dn * (2 * static_cast<double>(h) / kWaveHeights - 1) : 0;
      tables.emplace_back(chain_, exposure(mean_time_), colour, noise_, low, high, wave_dn);
    }
    return tables;
  }

  // The wave of amplitude 1 at a sample.
  double unit_wave(size_t sample) const {
    return wave_[sample / static_cast<size_t>(data_.channels)];
  }

  // Between the two nearest of the heights to which a wave that is cut off is tabulated.
  Response beside_wave(const std::vector<ResponseTable>& tables, size_t sample,
                       double signal) const {
    const double place =
        std::clamp(0.5 * (unit_wave(sample) + 1) * kWaveHeights, 0.0, kWaveHeights - 1e-9);
    const auto h = static_cast<size_t>(place);
    return between(tables[h].at(signal), tables[h + 1].at(signal), place - static_cast<double>(h));
  }

  // The fixed wave, less where values are clipped.
  void add_wave(LevelPrediction& out) const {
    if (!(chain_.wave.amplitude_dn > 0)) return;
    for (size_t i = 0; i < out.mean.size(); ++i) {
      const double here = chain_.wave.amplitude_dn * unit_wave(i) * out.offset_slope[i];
      out.mean[i] += here;
      if (!out.hot_mean.empty()) out.hot_mean[i] += here;
      if (!out.weak_mean.empty()) out.weak_mean[i] += here;
    }
  }

  // One step towards the illumination that fits the level's mean best.
  void correct_illumination(LevelPrediction& out, bool shift_mean) {
    double slope2 = 0, slope_residual = 0;
    for (size_t i = 0; i < out.mean.size(); ++i) {
      const double slope = lit_slope(out, i), w = slope / out.variance[i];
      slope2 += w * slope;
      slope_residual += w * (sum_.mean[i] - out.mean[i]);
    }
    if (!(slope2 > 0)) return;
    const double relative = std::clamp(slope_residual / slope2, -0.5, 1.0);
    out.illumination *= 1 + relative;
    if (!shift_mean) return;
    for (size_t i = 0; i < out.mean.size(); ++i) out.mean[i] += lit_slope(out, i) * relative;
  }

  void shift_rows(LevelPrediction& out, const std::vector<std::vector<double>>& lamps,
                  const std::vector<double>& row_light) {
    out.row_shift.assign(sum_.frames.size(), std::vector<double>(data_.rows(), 0));
    if (lamps.empty()) return;
    std::vector<double> slope(data_.rows(), 0);
    for (size_t i = 0; i < out.mean.size(); ++i)
      slope[row_of(i)] += lit_slope(out, i) / data_.width_px;
    for (size_t f = 0; f < lamps.size(); ++f) {
      for (size_t row = 0; row < data_.rows(); ++row) {
        const size_t v = row / data_.channels;
        out.row_shift[f][row] = slope[row] * (lamps[f][v] / std::max(row_light[v], 1e-6) - 1);
      }
    }
  }

  // Users' formulas of time: the change of each row's mean from the level's mean time.
  void drift_rows(LevelPrediction& out) {
    const effects::GainField lens(model_, effects::Stage::radiometry, data_.sensor_width(),
                                  data_.sensor_height());
    const effects::GainField lamps(model_, effects::Stage::light, data_.sensor_width(),
                                   data_.sensor_height());
    const effects::OwnLight own_light(model_, data_.sensor_width(), data_.sensor_height());
    const double scale = effects::signal_dn(chain_, out.illumination, exposure(0));
    const auto row_value = [&](int v, int colour, double t) {
      double sum = 0;
      constexpr int kPlaces = 5;
      for (int k = 0; k < kPlaces; ++k) {
        const double u = (k + 0.5) / kPlaces * data_.sensor_width() - 0.5;
        const double light = std::max(
            0.0, lens.at(u, data_.row(v), t, colour) * lamps.at(u, data_.row(v), t, colour));
        const double own = own_scale_ * own_light.at(u, data_.row(v));
        sum += effects::response_moments(chain_, scale * light + own, colour, exposure(t)).mean_dn;
      }
      return sum / kPlaces;
    };
    std::vector<double> mean_shift(data_.rows(), 0);
    for (size_t row = 0; row < data_.rows(); ++row) {
      const int v = static_cast<int>(row) / data_.channels;
      const int colour = data_.colour(static_cast<int>(row) % data_.channels);
      const double at_mean = row_value(v, colour, mean_time_);
      for (size_t f = 0; f < sum_.frames.size(); ++f) {
        const double shift = row_value(v, colour, time_of(sum_.frames[f])) - at_mean;
        out.row_shift[f][row] += shift;
        mean_shift[row] += shift / static_cast<double>(sum_.frames.size());
      }
      for (auto& frame : out.row_shift) frame[row] -= mean_shift[row];
    }
    for (size_t i = 0; i < out.mean.size(); ++i) out.mean[i] += mean_shift[row_of(i)];
  }

  double own_signal(size_t sample) const {
    return own_light_.empty() ? 0 : own_scale_ * own_light_[sample];
  }
  // d mean / d log(light of the scene).
  static double lit_slope(const LevelPrediction& out, size_t sample) {
    return out.gain_slope[sample] * (out.lit_part.empty() ? 1 : out.lit_part[sample]);
  }

  size_t row_of(size_t sample) const {
    return sample / (static_cast<size_t>(data_.width_px) * data_.channels) * data_.channels +
           sample % data_.channels;
  }

  const PhotometryData& data_;
  const effects::Model& model_;
  const SensorChain& chain_;
  const std::vector<double>& own_light_;
  const std::vector<double>& wave_;  // Of amplitude 1, by pixel; empty: none.
  const PhotometryLevel& level_;
  const LevelSums& sum_;
  SetNoise noise_;
  double mean_time_ = 0;
  double own_scale_ = 0;  // Signal of the camera's own light of 1.
};

// The fixed wave of amplitude 1, by pixel; empty: there is none.
std::vector<double> unit_wave(const PhotometryData& data, const SensorChain& chain) {
  std::vector<double> wave;
  if (!(chain.wave.amplitude_dn > 0)) return wave;
  wave.reserve(static_cast<size_t>(data.width_px) * static_cast<size_t>(data.height_px));
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u)
      wave.push_back(chain.wave.unit_at(data.column(u), data.row(v)));
  }
  return wave;
}

}  // namespace

bool depends_on_time(const effects::Model& model) {
  for (const auto& effect : model.effects()) {
    const bool user = !effects::expression_source(*effect.definition).empty();
    if (user && (effect.definition->gain || effect.definition->sensor)) return true;
  }
  return false;
}

std::vector<double> relative_light(const PhotometryData& data, const effects::Model& model,
                                   double t_s) {
  const effects::GainField lens(model, effects::Stage::radiometry, data.sensor_width(),
                                data.sensor_height());
  const effects::GainField lamps(model, effects::Stage::light, data.sensor_width(),
                                 data.sensor_height());
  std::vector<double> light(data.samples(), 1);
  if (lens.uniform() && lamps.uniform()) return light;
  size_t i = 0;
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u) {
      for (int c = 0; c < data.channels; ++c, ++i) {
        const int column = data.column(u), row = data.row(v), colour = data.colour(c);
        light[i] =
            std::max(0.0, lens.at(column, row, t_s, colour) * lamps.at(column, row, t_s, colour));
      }
    }
  }
  const double glare = effects::optics_of(model).glare_fraction;
  if (glare > 0) {
    double mean[3] = {0, 0, 0};
    for (size_t k = 0; k < light.size(); ++k) mean[k % data.channels] += light[k];
    const double pixels = static_cast<double>(data.width_px) * data.height_px;
    for (size_t k = 0; k < light.size(); ++k) {
      light[k] = (1 - glare) * light[k] + glare * mean[k % data.channels] / pixels;
    }
  }
  return light;
}

std::vector<double> own_light(const PhotometryData& data, const effects::Model& model) {
  const effects::OwnLight own(model, data.sensor_width(), data.sensor_height());
  if (own.none()) return {};
  std::vector<double> light;
  light.reserve(data.samples());
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u)
      light.insert(light.end(), static_cast<size_t>(data.channels),
                   own.at(data.column(u), data.row(v)));
  }
  return light;
}

double lamp_row(const PhotometryData& data, int frame, int row, double exposure_s,
                const effects::Model& model) {
  const double stamp = data.frames[frame].time_s;
  const double after = effects::timing_of(model).row_start_after_stamp_s(
      data.row(row), stamp - data.frames[0].time_s);
  return effects::lamp_brightness(model, {.start_s = stamp + after, .exposure_s = exposure_s});
}

std::vector<double> lamp_rows(const PhotometryData& data, int frame, double exposure_s,
                              const effects::Model& model) {
  std::vector<double> brightness;
  for (int v = 0; v < data.height_px; ++v)
    brightness.push_back(lamp_row(data, frame, v, exposure_s, model));
  return brightness;
}

effects::SensorChain chain_of(const effects::EffectDefinition& effect) {
  std::vector<double> values;
  for (const effects::Parameter& one : effect.parameters) values.push_back(one.neutral + one.scale);
  SensorChain chain;
  if (effect.sensor) effect.sensor(values, chain);
  return chain;
}

effects::SensorChain chain_before_mixing(const effects::Model& model, int file_bits) {
  SensorChain chain = effects::sensor_of(model);
  if (!chain.mixing.acts()) return chain;
  const double step = effects::quantisation_step(chain, file_bits),
               larger = effects::unmixed_variance(chain.mixing);
  // A filter that sharpens makes it smaller.
  const double rounding2 = std::max(0.0, step * step / 12 * (larger - 1));
  chain.read_sigma_dn = std::sqrt(chain.read_sigma_dn * chain.read_sigma_dn + rounding2);
  return chain;
}

PhotometryPrediction predict(const PhotometryData& data, const PhotometrySums& sums,
                             const effects::Model& model, double set_noise_dn) {
  PhotometryPrediction out{.chain = chain_before_mixing(model, data.file_bits)};
  const bool moving = depends_on_time(model);
  out.moves = moving || effects::lamps_flicker(model);
  const std::vector<double> own = own_light(data, model), wave = unit_wave(data, out.chain);
  std::vector<double> light;
  if (!moving) light = relative_light(data, model, 0);
  for (size_t l = 0; l < data.levels.size(); ++l) {
    if (sums.levels[l].frames.empty()) {
      out.levels.emplace_back();
      continue;
    }
    if (moving) {
      double t = 0;
      for (const int frame : sums.levels[l].frames)
        t += data.frames[frame].time_s - data.frames[0].time_s;
      light = relative_light(data, model, t / static_cast<double>(sums.levels[l].frames.size()));
    }
    out.levels.push_back(LevelPredictor(data, model, out.chain, own, wave, data.levels[l],
                                        sums.levels[l], set_noise_dn)
                             .run(light, moving));
    out.nuisances += std::isnan(data.levels[l].illumination);
    out.falls = out.falls || out.levels.back().falls;
  }
  return out;
}

}  // namespace seam::measurement
