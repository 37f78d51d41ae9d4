#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/stages/optics.h"
#include "effects/stages/timing.h"
#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {

PhotometryScore CellLikelihood::run(bool counts) {
  lamps_.resize(levels_);
  score_.values = sums_.values;
  score_.by_frame.assign(data_.frames.size(), 0);
  for (size_t k = 0; k < levels_; ++k) {
    predict_level(k);
    add_changes(k);
    if (counts) count_certain(k);
    score_.nuisances += std::isnan(data_.levels[sums_.present[k]].illumination);
  }
  add_means();
  if (set_likelihood(total_, falls_, sums_, score_)) share_among_frames();
  return score_;
}

// What frames have in common is divided equally.
void CellLikelihood::share_among_frames() {
  double assigned = 0, count = 0;
  for (const double own : score_.by_frame) assigned += own;
  for (size_t k = 0; k < levels_; ++k) count += frames(k);
  for (size_t k = 0; k < levels_; ++k) {
    for (const int frame : sum(k).frames)
      score_.by_frame[frame] += (score_.log_likelihood - assigned) / count;
  }
}

void CellLikelihood::count_certain(size_t k) {
  const CertainValues certain(data_, chain_);
  const auto is_certain = [&](const Entry& e) { return certain.is_certain(e.mean, e.variance); };
  bool any = false;
  for (size_t cell = 0; cell < sorted_.count(); ++cell) any = any || is_certain(entry(cell, k));
  if (!any) return;
  const LevelSums& level = sum(k);
  for (size_t i = 0; i < level.mean.size(); ++i) {
    const Entry& here = entry(sorted_.of_sample[i], k);
    if (!is_certain(here)) continue;
    const double wave = cells_.wave.empty() ? 0 : here.wave * cells_.wave[i];
    const double r = level.mean[i] - here.mean - here.slope * cells_.offset[i] - wave;
    if (certain.fits(here.mean + wave, r * r + level.scatter[i] / frames(k)))
      score_.values -= static_cast<int64_t>(level.frames.size());
  }
}

void CellLikelihood::predict_level(size_t k) {
  const PhotometryLevel& level = data_.levels[sums_.present[k]];
  double lamps = 1;
  if (flickers_) {
    lamps = 0;
    for (const int frame : sum(k).frames) {
      lamps_[k].push_back(lamp_row(data_, frame, 0, level.exposure_s, model_));
      lamps += lamps_[k].back() / frames(k);
    }
    for (double& own : lamps_[k]) own = own / std::max(lamps, 1e-6) - 1;
  }
  const effects::SensorExposure exposure{.exposure_s = level.exposure_s,
                                         .exposure_ratio = level.exposure_ratio,
                                         .gain = level.gain,
                                         .file_bits = data_.file_bits};
  const double per_light = effects::signal_dn(chain_, 1, exposure);
  if (!std::isnan(level.illumination)) {
    fill(k, level.illumination, lamps, exposure);
    falls_ = falls_ || !rises_to(per_light * level.illumination * lamps);
    return;
  }
  // Unknown light: as much as fits the level's mean best.
  double illumination = std::max(1e-6, (sums_.reference[k] - chain_.black_dn) / per_light);
  for (int step = 0; step < 4; ++step) {
    fill(k, illumination, lamps, exposure);
    const double relative = correction(k);
    illumination *= 1 + relative;
    if (step < 3) continue;
    for (size_t cell = 0; cell < sorted_.count(); ++cell)
      entry(cell, k).mean += entry(cell, k).gain_slope * relative;
  }
  falls_ = falls_ || !rises_to(per_light * illumination * lamps);
}

// Whether the response does, to the brightest sample of a level.
bool CellLikelihood::rises_to(double scale) const {
  for (int c = 0; c < data_.channels; ++c) {
    if (!effects::rises_with_light(chain_, scale * cells_.most[c], data_.colour(c),
                                   data_.file_bits))
      return false;
  }
  return true;
}

void CellLikelihood::fill(size_t k, double illumination, double lamps,
                          const effects::SensorExposure& exposure) {
  const double scale = effects::signal_dn(chain_, illumination, exposure) * lamps;
  // Without light and dark current all levels are one.
  const bool is_one_of_all =
      scale == 0 && chain_.dark_electrons_per_s == 0 && chain_.dark_sigma_dn_per_s == 0 &&
      chain_.maps.empty() &&
      exposure.gain == data_.levels[sums_.present[dark_level_.value_or(k)]].gain;
  if (is_one_of_all && dark_level_) {
    for (size_t cell = 0; cell < sorted_.count(); ++cell)
      entry(cell, k) = entry(cell, *dark_level_);
    return;
  }
  if (is_one_of_all) dark_level_ = k;
  // Few cells are evaluated themselves; a table serves many.
  constexpr size_t kFewCells = 64;
  for (int c = 0; c < data_.channels; ++c) {
    const size_t first = sorted_.first[c], last = sorted_.first[c + 1];
    std::optional<ResponseTable> table;
    const double darkest = scale * cells_.least[c], brightest = scale * cells_.most[c];
    if (scale != 0 && sorted_.wave_centre.empty() &&
        (last - first > kFewCells ||
         2 * ResponseTable::size_for(chain_, exposure, data_.colour(c), darkest, brightest) <
             last - first))
      table.emplace(chain_, exposure, data_.colour(c), noise_, darkest, brightest);
    Response dark;
    double dark_wave_dn = std::numeric_limits<double>::quiet_NaN();
    for (size_t cell = first; cell < last; ++cell) {
      const double signal = scale * cells_.light[cell];
      const double wave_dn =
          sorted_.wave_centre.empty() ? 0 : chain_.wave.amplitude_dn * sorted_.wave_centre[cell];
      if (scale == 0 && wave_dn != dark_wave_dn) {
        dark = dark_.of(chain_, exposure, data_.colour(c), noise_, wave_dn);
        dark_wave_dn = wave_dn;
      }
      const Response here =
          scale == 0 ? dark
          : table    ? table->at(signal)
                     : respond(chain_, exposure, data_.colour(c), noise_, signal, wave_dn);
      Entry& out = entry(cell, k);
      out = {.mean = here.mean,
             .variance = here.variance,
             .offset_slope = here.offset_slope,
             .gain_slope = here.gain_slope,
             .wave = chain_.wave.amplitude_dn * here.offset_slope,
             .odd = {here.hot_mean - here.mean, here.weak_mean - here.mean}};
      const double low = cells_.low[cell], high = cells_.high[cell];
      if (!(high > low)) continue;
      out.slope = table
                      ? (table->at(scale * high).mean - table->at(scale * low).mean) / (high - low)
                      : here.gain_slope / std::max(cells_.light[cell], 1e-12);
    }
  }
}

// Relative step of a level's light towards its mean.
double CellLikelihood::correction(size_t k) {
  double slope2 = 0, slope_residual = 0;
  for (size_t cell = 0; cell < sorted_.count(); ++cell) {
    const Entry& here = entry(cell, k);
    const double w = here.gain_slope / here.variance;
    slope2 += w * here.gain_slope * sorted_.samples[cell];
    slope_residual += w * residual_sum(cell, k);
  }
  return slope2 > 0 ? std::clamp(slope_residual / slope2, -0.5, 1.0) : 0;
}

// Averages over each row of what cells predict: from the row's light where it is linear in the
// light.
template <typename F>
std::vector<double> CellLikelihood::row_averages(size_t k, F&& value) {
  constexpr double kLinear = 1e-7;
  const size_t rows = data_.rows(), channels = data_.channels;
  std::vector<double> out(rows, 0);
  bool linear = true;
  for (size_t c = 0; c < channels; ++c) {
    const size_t first = sorted_.first[c], last = sorted_.first[c + 1] - 1;
    const double low = value(entry(first, k)), high = value(entry(last, k));
    const double light = cells_.light[first], range = cells_.light[last] - light;
    const auto at = [&](double x) {
      return range > 0 ? low + (high - low) * (x - light) / range : low;
    };
    const double tolerance = kLinear * std::max(std::abs(low), std::abs(high));
    for (size_t cell = first; cell <= last && linear; ++cell)
      linear = std::abs(value(entry(cell, k)) - at(cells_.light[cell])) <= tolerance;
    for (size_t row = c; row < rows; row += channels) out[row] = at(cells_.row_light[row]);
  }
  if (linear) return out;
  out.assign(rows, 0);
  const SampleGroups& groups = sorted_.by_row;
  for (size_t g = 0; g < groups.count(); ++g) {
    const auto channel = static_cast<size_t>(sorted_.channel[groups.cell[g]]);
    out[groups.place[g] * channels + channel] +=
        groups.samples[g] * value(entry(groups.cell[g], k));
  }
  for (double& x : out) x /= data_.width_px;
  return out;
}

// Sum over samples of the squared difference of their gain from their row's, over their variance.
double CellLikelihood::gain_scatter(size_t k, const std::vector<double>& row_gain) {
  if (sorted_.count() == static_cast<size_t>(data_.channels)) return 0;
  const auto channels = static_cast<size_t>(data_.channels);
  const SampleGroups& groups = sorted_.by_row;
  double sum = 0;
  for (size_t g = 0; g < groups.count(); ++g) {
    const Entry& here = entry(groups.cell[g], k);
    const auto channel = static_cast<size_t>(sorted_.channel[groups.cell[g]]);
    const double d = here.gain_slope - row_gain[groups.place[g] * channels + channel];
    sum += groups.samples[g] * d * d / here.variance;
  }
  return sum;
}

// Changes in time within a level: of rows from frame to frame, and what is left within rows.
void CellLikelihood::add_changes(size_t k) {
  double log_variance = 0, scatter = 0;
  for (size_t cell = 0; cell < sorted_.count(); ++cell) {
    log_variance += sorted_.samples[cell] * std::log(entry(cell, k).variance);
    scatter += sorted_.scatter[cell * levels_ + k] / entry(cell, k).variance;
    score_.square += sorted_.scatter[cell * levels_ + k];
  }
  total_.log_det += log_variance;
  if (sum(k).frames.size() < 2) return;
  const auto width = static_cast<double>(data_.width_px);
  const double freedom = frames(k) - 1;
  total_.log_det += log_variance * freedom * (width - 1) / width;
  total_.chi2 += scatter;
  const size_t rows = data_.rows();
  const double spread = chain_.row_sigma_dn * chain_.row_sigma_dn;
  const auto variance = row_averages(k, [](const Entry& e) { return e.variance; });
  std::vector<double> slope2(rows, 0), gain(rows, 0);
  if (spread > 0)
    slope2 = row_averages(k, [](const Entry& e) { return e.offset_slope * e.offset_slope; });
  if (flickers_) {
    gain = row_averages(k, [](const Entry& e) { return e.gain_slope; });
    // Lamps move a row's parts in proportion to their light: what that adds to the scatter is
    // subtracted.
    double moved = 0;
    for (const double own : lamps_[k]) moved += own * own;
    total_.chi2 -= moved * gain_scatter(k, gain);
  }
  add_rows_of_frames(k, variance, slope2, gain);
}

// Means of rows from frame to frame, with the rows' noise and the frames' own light.
void CellLikelihood::add_rows_of_frames(size_t k, const std::vector<double>& variance,
                                        const std::vector<double>& slope2,
                                        const std::vector<double>& gain) {
  const LevelSums& level = sum(k);
  const auto count = static_cast<double>(level.frames.size());
  const auto width = static_cast<double>(data_.width_px);
  const double spread = chain_.row_sigma_dn * chain_.row_sigma_dn;
  const double lamp2 = chain_.lamp_sigma * chain_.lamp_sigma;
  const auto channels = static_cast<size_t>(data_.channels);
  LogSum logs;
  double lamp_info = 0;
  std::vector<double> lamp_score(level.frames.size(), 0), chi2(level.frames.size(), 0);
  std::vector<double> load(channels), lamp_gain(data_.rows(), 0);
  if (lamp2 > 0) lamp_gain = row_averages(k, [](const Entry& e) { return e.gain_slope; });
  const auto residual = [&](size_t f, size_t row) {
    const double shift = flickers_ ? gain[row] * lamps_[k][f] : 0;
    return data_.row_mean[level.frames[f]][row] - level.row_mean[row] - shift;
  };
  for (size_t v = 0; v < static_cast<size_t>(data_.height_px); ++v) {
    double info = 0, log_det = 0;
    for (size_t c = 0; c < channels; ++c) {
      const size_t row = v * channels + c;
      const double own = variance[row] / width, load2 = spread * slope2[row];
      logs.add(variance[row]);
      load[c] = std::sqrt(load2) / own;
      info += load2 / own;
      for (size_t f = 0; f < level.frames.size(); ++f) {
        const double r = residual(f, row);
        chi2[f] += r * r / own;
        lamp_score[f] += lamp_gain[row] * r / (own + load2);
      }
      lamp_info += lamp_gain[row] * lamp_gain[row] / (own + load2);
      if (load2 == 0 || (share_ && c + 1 < channels)) continue;
      log_det += std::log1p(info);
      for (size_t f = 0; f < level.frames.size(); ++f) {
        double score = 0;
        for (size_t from = share_ ? 0 : c; from <= c; ++from)
          score += load[from] * residual(f, v * channels + from);
        chi2[f] -= score * score / (1 + info);
      }
      info = 0;
    }
    total_.log_det += (count - 1) * log_det;
    for (const int frame : level.frames)
      score_.by_frame[frame] -= 0.5 * log_det * (count - 1) / count;
  }
  double common = logs.total();
  total_.log_det += (count - 1) * common;
  if (lamp2 > 0) {
    const double own = std::log1p(lamp2 * lamp_info);
    total_.log_det += (count - 1) * own;
    common += own;
    for (size_t f = 0; f < level.frames.size(); ++f)
      chi2[f] -= lamp2 * lamp_score[f] * lamp_score[f] / (1 + lamp2 * lamp_info);
  }
  for (size_t f = 0; f < level.frames.size(); ++f) {
    total_.chi2 += chi2[f];
    score_.by_frame[level.frames[f]] -= 0.5 * (chi2[f] + common * (count - 1) / count);
  }
  for (const int frame : level.frames) {
    for (size_t row = 0; row < data_.rows(); ++row) {
      const double d = data_.row_mean[frame][row] - level.row_mean[row];
      score_.square += width * d * d;
    }
  }
}

std::optional<PhotometryScore> cell_score(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share, bool counts,
                                          const effects::Model* near) {
  if (depends_on_time(model)) return std::nullopt;
  // Samples of one light of the lamps have several of the camera's own.
  if (!effects::OwnLight(model, data.sensor_width(), data.sensor_height()).none())
    return std::nullopt;
  if (effects::lamps_flicker(model) && effects::timing_of(model).line_delay_s != 0)
    return std::nullopt;
  const bool share = channels_share || data.channels == 1;
  const effects::SensorChain chain = effects::sensor_of(model);
  const CellNeeds needs{.products = chain.has_pixel_patterns(),
                        .groups = chain.row_sigma_dn > 0 || chain.column_sigma_dn > 0};
  const auto cells = store.cells(data, sums, model, needs, near);
  return CellLikelihood(data, sums, *cells, store.dark_responses(), model, set_noise_dn, share)
      .run(counts);
}

std::optional<double> cell_log_likelihood(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share,
                                          const effects::Model* near) {
  const auto score =
      cell_score(data, sums, store, model, set_noise_dn, channels_share, false, near);
  if (!score) return std::nullopt;
  return score->log_likelihood;
}

}  // namespace seam::measurement
