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

double CellLikelihood::run() {
  lamps_.resize(levels_);
  for (size_t k = 0; k < levels_; ++k) {
    predict_level(k);
    add_changes(k);
  }
  add_means();
  // Where variances differ wildly along rows, as at clipping, rows and columns are no longer told
  // apart exactly: what comes out beyond zero is no likelihood.
  if (!(total_.chi2 >= 0)) return -std::numeric_limits<double>::infinity();
  return -0.5 * (total_.chi2 + total_.log_det +
                 static_cast<double>(sums_.values) * std::log(2 * maths::kPi));
}

void CellLikelihood::predict_level(size_t k) {
  const PhotometryLevel& level = data_.levels[cells_.present[k]];
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
  if (!std::isnan(level.illumination)) {
    fill(k, level.illumination, lamps, exposure);
    return;
  }
  // Unknown light: as much as fits the level's mean best.
  const double per_light = effects::signal_dn(chain_, 1, exposure);
  double illumination = std::max(1e-6, (cells_.reference[k] - chain_.black_dn) / per_light);
  for (int step = 0; step < 4; ++step) {
    fill(k, illumination, lamps, exposure);
    const double relative = correction(k);
    illumination *= 1 + relative;
    if (step < 3) continue;
    for (size_t cell = 0; cell < cells_.count(); ++cell)
      entry(cell, k).mean += entry(cell, k).gain_slope * relative;
  }
}

void CellLikelihood::fill(size_t k, double illumination, double lamps,
                          const effects::SensorExposure& exposure) {
  const double scale = effects::signal_dn(chain_, illumination, exposure) * lamps;
  std::vector<ResponseTable> tables;
  for (int c = 0; c < data_.channels; ++c)
    tables.emplace_back(chain_, exposure, data_.colour(c), noise_, scale * cells_.least[c],
                        scale * cells_.most[c]);
  for (size_t cell = 0; cell < cells_.count(); ++cell) {
    const ResponseTable& table = tables[cells_.channel[cell]];
    const Response here = table.at(scale * cells_.light[cell]);
    Entry& out = entry(cell, k);
    out = {.mean = here.mean,
           .variance = here.variance,
           .offset_slope = here.offset_slope,
           .gain_slope = here.gain_slope,
           .hot = here.hot_mean - here.mean};
    const double low = cells_.low[cell], high = cells_.high[cell];
    if (high > low)
      out.slope = (table.at(scale * high).mean - table.at(scale * low).mean) / (high - low);
  }
}

// Relative step of a level's light towards its mean.
double CellLikelihood::correction(size_t k) {
  double slope2 = 0, slope_residual = 0;
  for (size_t cell = 0; cell < cells_.count(); ++cell) {
    const Entry& here = entry(cell, k);
    const double w = here.gain_slope / here.variance;
    slope2 += w * here.gain_slope * cells_.samples[cell];
    slope_residual += w * (cells_.mean[cell * levels_ + k] -
                           cells_.samples[cell] * (here.mean - cells_.reference[k]));
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
    const size_t first = cells_.first[c], last = cells_.first[c + 1] - 1;
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
  const size_t row_samples = data_.width_px * channels;
  for (size_t i = 0; i < cells_.of_sample.size(); ++i)
    out[i / row_samples * channels + i % channels] += value(entry(cells_.of_sample[i], k));
  for (double& x : out) x /= data_.width_px;
  return out;
}

// Sum over samples of the squared difference of their gain from their row's, over their variance.
double CellLikelihood::gain_scatter(size_t k, const std::vector<double>& row_gain) {
  if (cells_.count() == static_cast<size_t>(data_.channels)) return 0;
  const size_t channels = data_.channels, row_samples = data_.width_px * channels;
  double sum = 0;
  for (size_t i = 0; i < cells_.of_sample.size(); ++i) {
    const Entry& here = entry(cells_.of_sample[i], k);
    const double d = here.gain_slope - row_gain[i / row_samples * channels + i % channels];
    sum += d * d / here.variance;
  }
  return sum;
}

// Changes in time within a level: of rows from frame to frame, and what is left within rows.
void CellLikelihood::add_changes(size_t k) {
  LogSum logs;
  double log_variance = 0, scatter = 0;
  for (size_t cell = 0; cell < cells_.count(); ++cell) {
    log_variance += cells_.samples[cell] * std::log(entry(cell, k).variance);
    scatter += cells_.scatter[cell * levels_ + k] / entry(cell, k).variance;
  }
  total_.log_det += log_variance;
  const size_t count = sum(k).frames.size();
  if (count < 2) return;
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
  const int channels = data_.channels;
  for (size_t v = 0; v < static_cast<size_t>(data_.height_px); ++v) {
    double info = 0;
    std::vector<double> load(channels);
    for (int c = 0; c < channels; ++c) {
      const size_t row = v * channels + c;
      logs.add(variance[row]);
      const double load2 = spread * slope2[row];
      load[c] = std::sqrt(load2) * width / variance[row];
      info += load2 * width / variance[row];
      if (load2 == 0 || (share_ && c + 1 < channels)) continue;
      total_.log_det += freedom * std::log1p(info);
      const int first = share_ ? 0 : c;
      for (size_t f = 0; f < count; ++f) {
        const auto& means = data_.row_mean[sum(k).frames[f]];
        double score = 0;
        for (int own = first; own <= c; ++own) {
          const size_t at = v * channels + own;
          const double shift = flickers_ ? gain[at] * lamps_[k][f] : 0;
          score += load[own] * (means[at] - sum(k).row_mean[at] - shift);
        }
        total_.chi2 -= score * score / (1 + info);
      }
      info = 0;
    }
  }
  total_.log_det += freedom * logs.total();
  for (size_t f = 0; f < count; ++f) {
    const auto& means = data_.row_mean[sum(k).frames[f]];
    const double lamps = flickers_ ? lamps_[k][f] : 0;
    for (size_t row = 0; row < rows; ++row) {
      const double r = means[row] - sum(k).row_mean[row] - gain[row] * lamps;
      total_.chi2 += r * r * width / variance[row];
    }
  }
}

std::optional<double> cell_log_likelihood(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share) {
  if (depends_on_time(model)) return std::nullopt;
  if (effects::lamps_flicker(model) && effects::timing_of(model).line_delay_s != 0)
    return std::nullopt;
  const bool share = channels_share || data.channels == 1;
  const effects::SensorChain chain = effects::sensor_of(model);
  const bool pixels = chain.pixel_offset_sigma_dn > 0 || chain.pixel_gain_sigma > 0;
  const auto cells = store.cells(data, sums, model, pixels);
  return CellLikelihood(data, sums, *cells, model, set_noise_dn, share).run();
}

}  // namespace seam::measurement
