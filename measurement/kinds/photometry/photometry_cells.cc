#include "measurement/kinds/photometry/photometry_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "effects/stages/optics.h"
#include "effects/stages/timing.h"
#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/photometry_rows.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

using effects::SensorExposure;

// What a level predicts for a cell.
struct Entry {
  double mean = 0;   // At the cell's mean light.
  double slope = 0;  // d mean / d light.
  double variance = 1, offset_slope = 1, gain_slope = 0;
  double hot = 0;  // A hot sample's mean less that of others.
};

class CellLikelihood {
 public:
  CellLikelihood(const PhotometryData& data, const PhotometrySums& sums, const LightCells& cells,
                 const effects::Model& model, double set_noise_dn, bool share)
      : data_(data),
        sums_(sums),
        cells_(cells),
        model_(model),
        chain_(effects::sensor_of(model)),
        noise_(set_noise_dn),
        share_(share),
        flickers_(effects::lamps_flicker(model)),
        levels_(cells.present.size()),
        entries_(cells.count() * levels_) {}

  double run() {
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

 private:
  const LevelSums& sum(size_t k) const { return sums_.levels[cells_.present[k]]; }
  double frames(size_t k) const { return static_cast<double>(sum(k).frames.size()); }
  Entry& entry(size_t cell, size_t k) { return entries_[cell * levels_ + k]; }
  size_t unit(int place, int channel) const {
    return share_ ? static_cast<size_t>(place)
                  : static_cast<size_t>(place) * data_.channels + channel;
  }

  void predict_level(size_t k);
  void fill(size_t k, double illumination, double lamps, const SensorExposure& exposure);
  double correction(size_t k);
  template <typename F>
  std::vector<double> row_averages(size_t k, F&& value);
  double gain_scatter(size_t k, const std::vector<double>& row_gain);
  void add_changes(size_t k);
  void add_means();
  void add_samples();

  // Of residuals from the prediction: sum over a cell's samples of r_k r_l, l <= k.
  double product(size_t cell, size_t k, size_t l) {
    const Entry &a = entry(cell, k), &b = entry(cell, l);
    const double ma = a.mean - cells_.reference[k], mb = b.mean - cells_.reference[l];
    const size_t at = cell * levels_;
    return cells_.products[(at + k) * levels_ + l] - ma * cells_.mean[at + l] -
           mb * cells_.mean[at + k] + cells_.samples[cell] * ma * mb -
           a.slope * cells_.with_offset[at + l] - b.slope * cells_.with_offset[at + k] +
           a.slope * b.slope * cells_.offset2[cell];
  }

  const PhotometryData& data_;
  const PhotometrySums& sums_;
  const LightCells& cells_;
  const effects::Model& model_;
  effects::SensorChain chain_;
  double noise_;
  bool share_, flickers_;
  size_t levels_;
  std::vector<Entry> entries_;
  std::vector<std::vector<double>> lamps_;  // By level and frame: brightness over the level's mean.

  // By cell, for its samples: the inverse of their covariance between levels, in parts.
  struct Inverse {
    PatternInverse two;
    double hot_square = 0;    // h' Sigma^-1 h, h the offset of a hot sample.
    double slope_square = 0;  // The same of the slopes by an offset.
  };
  std::vector<Inverse> inverse_;
  // By cell * levels + k.
  std::vector<double> weight_, offset_load_, gain_load_, hot_vector_, slope_vector_;
  // By (cell * levels + k) * levels + l: s_k (Sigma^-1)_kl s_l; empty without pixels' patterns.
  std::vector<double> slope_products_;
  Quadratic total_;
};

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
  const SensorExposure exposure{.exposure_s = level.exposure_s,
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
                          const SensorExposure& exposure) {
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

// Means over time, with fixed patterns as random effects.
void CellLikelihood::add_means() {
  const bool pixels = chain_.pixel_offset_sigma_dn > 0 || chain_.pixel_gain_sigma > 0;
  const bool hot = chain_.hot_fraction > 0;
  const bool structured = chain_.row_sigma_dn > 0 || chain_.column_sigma_dn > 0;
  inverse_.resize(cells_.count());
  for (auto* v : {&weight_, &offset_load_, &gain_load_, &hot_vector_, &slope_vector_})
    v->assign(entries_.size(), 0);
  if (structured && pixels) slope_products_.resize(entries_.size() * levels_);
  for (size_t cell = 0; cell < cells_.count(); ++cell) {
    const size_t at = cell * levels_;
    Inverse& inverse = inverse_[cell];
    for (size_t k = 0; k < levels_; ++k) {
      const Entry& here = entry(cell, k);
      weight_[at + k] = frames(k) / here.variance;
      total_.chi2 += weight_[at + k] * product(cell, k, k);
      offset_load_[at + k] = chain_.pixel_offset_sigma_dn * here.offset_slope;
      gain_load_[at + k] = chain_.pixel_gain_sigma * here.gain_slope;
    }
    if (pixels) {
      inverse.two = pattern_inverse(&offset_load_[at], &gain_load_[at], &weight_[at], levels_);
      total_.log_det += cells_.samples[cell] * inverse.two.log_det;
      double q00 = 0, q01 = 0, q11 = 0;
      for (size_t k = 0; k < levels_; ++k) {
        // From here on loads times weights.
        offset_load_[at + k] *= weight_[at + k], gain_load_[at + k] *= weight_[at + k];
      }
      for (size_t k = 0; k < levels_; ++k) {
        for (size_t l = 0; l <= k; ++l) {
          const double both = (k == l ? 1 : 2) * product(cell, k, l);
          q00 += both * offset_load_[at + k] * offset_load_[at + l];
          q01 += 0.5 * both *
                 (offset_load_[at + k] * gain_load_[at + l] +
                  offset_load_[at + l] * gain_load_[at + k]);
          q11 += both * gain_load_[at + k] * gain_load_[at + l];
        }
      }
      total_.chi2 -= inverse.two.i00 * q00 + 2 * inverse.two.i01 * q01 + inverse.two.i11 * q11;
    }
    // Sigma^-1 of a vector that the cell's samples share; returns its product with the vector.
    const auto solve = [&](auto value, std::vector<double>& out) {
      double b0 = 0, b1 = 0, square = 0;
      for (size_t k = 0; k < levels_; ++k)
        b0 += offset_load_[at + k] * value(k), b1 += gain_load_[at + k] * value(k);
      if (!pixels) b0 = b1 = 0;
      const double e0 = inverse.two.i00 * b0 + inverse.two.i01 * b1,
                   e1 = inverse.two.i01 * b0 + inverse.two.i11 * b1;
      for (size_t k = 0; k < levels_; ++k) {
        out[at + k] = weight_[at + k] * value(k) -
                      (pixels ? offset_load_[at + k] * e0 + gain_load_[at + k] * e1 : 0);
        square += out[at + k] * value(k);
      }
      return square;
    };
    if (structured && pixels) {
      for (size_t k = 0; k < levels_; ++k) {
        const double offset = offset_load_[at + k], gain = gain_load_[at + k];
        const PatternInverse& two = inverse.two;
        const double e0 = two.i00 * offset + two.i01 * gain, e1 = two.i01 * offset + two.i11 * gain;
        for (size_t l = 0; l < levels_; ++l) {
          const double own =
              (k == l ? weight_[at + k] : 0) - e0 * offset_load_[at + l] - e1 * gain_load_[at + l];
          slope_products_[(at + k) * levels_ + l] =
              own * entry(cell, k).offset_slope * entry(cell, l).offset_slope;
        }
      }
    }
    if (hot) inverse.hot_square = solve([&](size_t k) { return entry(cell, k).hot; }, hot_vector_);
    if (structured)
      inverse.slope_square =
          solve([&](size_t k) { return entry(cell, k).offset_slope; }, slope_vector_);
  }
  if (hot || structured) add_samples();
}

// What needs each sample's own residual: whether it is hot, and the sums over its row and column.
void CellLikelihood::add_samples() {
  struct Column {
    double info = 0, score = 0;
  };
  const bool pixels = chain_.pixel_offset_sigma_dn > 0 || chain_.pixel_gain_sigma > 0;
  const bool hot = chain_.hot_fraction > 0, columns_vary = chain_.column_sigma_dn > 0;
  const bool structured = columns_vary || chain_.row_sigma_dn > 0;
  const double log_cold = hot ? std::log1p(-chain_.hot_fraction) : 0,
               log_hot = hot ? std::log(chain_.hot_fraction) : 0;
  std::vector<Column> columns(static_cast<size_t>(data_.width_px) * (share_ ? 1 : data_.channels));
  RowOffsets rows(data_, sums_, share_);
  const size_t channels = data_.channels;
  std::vector<double> r(levels_);
  std::vector<const double*> means;
  for (size_t k = 0; k < levels_; ++k) means.push_back(sum(k).mean.data());
  int64_t hot_samples = 0;
  size_t i = 0;
  for (int v = 0; v < data_.height_px; ++v) {
    const size_t start = i;
    for (int u = 0; u < data_.width_px; ++u) {
      for (size_t c = 0; c < channels; ++c, ++i) {
        const size_t cell = cells_.of_sample[i], at = cell * levels_;
        const double offset = cells_.offset[i];
        for (size_t k = 0; k < levels_; ++k)
          r[k] = means[k][i] - entries_[at + k].mean - entries_[at + k].slope * offset;
        if (hot) {
          double along = 0;
          for (size_t k = 0; k < levels_; ++k) along += hot_vector_[at + k] * r[k];
          // A sample is hot where that is likelier; its residual is then taken from the hot mean.
          if (along - 0.5 * inverse_[cell].hot_square + log_hot > log_cold) {
            ++hot_samples;
            total_.chi2 += inverse_[cell].hot_square - 2 * along;
            for (size_t k = 0; k < levels_; ++k) r[k] -= entries_[at + k].hot;
          }
        }
        if (!structured) continue;
        double e0 = 0, e1 = 0;
        if (pixels) {
          double b0 = 0, b1 = 0;
          for (size_t k = 0; k < levels_; ++k)
            b0 += offset_load_[at + k] * r[k], b1 += gain_load_[at + k] * r[k];
          const PatternInverse& two = inverse_[cell].two;
          e0 = two.i00 * b0 + two.i01 * b1, e1 = two.i01 * b0 + two.i11 * b1;
        }
        double* score = rows.score(rows.unit(v, static_cast<int>(c)));
        double* precision = rows.precision(rows.unit(v, static_cast<int>(c)));
        double column = 0;
        for (size_t k = 0; k < levels_; ++k) {
          const double slope = entries_[at + k].offset_slope;
          double solved = weight_[at + k] * r[k];
          if (pixels) solved -= offset_load_[at + k] * e0 + gain_load_[at + k] * e1;
          score[k] += slope * solved;
          column += slope_vector_[at + k] * r[k];
          if (!pixels) {
            precision[k * levels_ + k] += slope * slope * weight_[at + k];
            continue;
          }
          const double* own = &slope_products_[(at + k) * levels_];
          for (size_t l = 0; l < levels_; ++l) precision[k * levels_ + l] += own[l];
        }
        if (columns_vary) columns[unit(u, static_cast<int>(c))].score += column;
      }
    }
    if (!columns_vary) continue;
    // Beside what their rows have in common.
    std::vector<std::vector<double>> common;
    for (int c = 0; c < (share_ ? 1 : data_.channels); ++c)
      common.push_back(rows.estimate(rows.unit(v, c)));
    i = start;
    for (int u = 0; u < data_.width_px; ++u) {
      for (size_t c = 0; c < channels; ++c, ++i) {
        const size_t cell = cells_.of_sample[i], at = cell * levels_;
        const std::vector<double>& own = common[share_ ? 0 : c];
        double along = 0;
        for (size_t k = 0; k < levels_; ++k)
          along += slope_vector_[at + k] * entries_[at + k].offset_slope * own[k];
        Column& column = columns[unit(u, static_cast<int>(c))];
        column.score -= along;
        column.info += inverse_[cell].slope_square;
      }
    }
  }
  const auto samples = static_cast<double>(data_.samples()),
             n_hot = static_cast<double>(hot_samples);
  total_.log_det -= 2 * (n_hot * log_hot + (samples - n_hot) * log_cold);
  if (columns_vary) {
    const double variance = chain_.column_sigma_dn * chain_.column_sigma_dn;
    // Their mean over columns is taken with the rows.
    const double part = (data_.width_px - 1.0) / data_.width_px;
    for (const Column& column : columns) {
      const double info = variance * column.info;
      total_.chi2 -= variance * column.score * column.score / (1 + info);
      total_.log_det += part * std::log1p(info);
    }
  }
  if (structured) rows.add(chain_, total_);
}

}  // namespace

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
