// Means over time of samples in cells of light, with fixed patterns as random effects.
#include <cmath>
#include <cstdint>

#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"

namespace seam::measurement {

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
    if (pixels) add_patterns(cell);
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
    if (structured && pixels) find_slope_products(cell);
    if (hot) inverse.hot_square = solve([&](size_t k) { return entry(cell, k).hot; }, hot_vector_);
    if (structured)
      inverse.slope_square =
          solve([&](size_t k) { return entry(cell, k).offset_slope; }, slope_vector_);
  }
  if (hot || structured) add_samples();
}

// What the offsets and gains of a cell's pixels take out of chi2. Leaves loads times weights.
void CellLikelihood::add_patterns(size_t cell) {
  const size_t at = cell * levels_;
  Inverse& inverse = inverse_[cell];
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
      q01 +=
          0.5 * both *
          (offset_load_[at + k] * gain_load_[at + l] + offset_load_[at + l] * gain_load_[at + k]);
      q11 += both * gain_load_[at + k] * gain_load_[at + l];
    }
  }
  total_.chi2 -= inverse.two.i00 * q00 + 2 * inverse.two.i01 * q01 + inverse.two.i11 * q11;
}

// From loads times weights, as add_patterns leaves them.
void CellLikelihood::find_slope_products(size_t cell) {
  const size_t at = cell * levels_;
  const PatternInverse& two = inverse_[cell].two;
  for (size_t k = 0; k < levels_; ++k) {
    const double offset = offset_load_[at + k], gain = gain_load_[at + k];
    const double e0 = two.i00 * offset + two.i01 * gain, e1 = two.i01 * offset + two.i11 * gain;
    for (size_t l = 0; l < levels_; ++l) {
      const double own =
          (k == l ? weight_[at + k] : 0) - e0 * offset_load_[at + l] - e1 * gain_load_[at + l];
      slope_products_[(at + k) * levels_ + l] =
          own * entry(cell, k).offset_slope * entry(cell, l).offset_slope;
    }
  }
}

struct CellLikelihood::SampleSums {
  struct Column {
    double info = 0, score = 0;
  };
  bool pixels, hot, columns_vary, structured;
  double log_cold, log_hot;  // Logarithms of the shares of samples.
  std::vector<Column> columns;
  RowOffsets rows;
  std::vector<const double*> means;  // By level, then sample.
  int64_t hot_samples = 0;
};

// What needs each sample's own residual: whether it is hot, and the sums over its row and column.
void CellLikelihood::add_samples() {
  const bool hot = chain_.hot_fraction > 0, columns_vary = chain_.column_sigma_dn > 0;
  SampleSums sums{.pixels = chain_.pixel_offset_sigma_dn > 0 || chain_.pixel_gain_sigma > 0,
                  .hot = hot,
                  .columns_vary = columns_vary,
                  .structured = columns_vary || chain_.row_sigma_dn > 0,
                  .log_cold = hot ? std::log1p(-chain_.hot_fraction) : 0,
                  .log_hot = hot ? std::log(chain_.hot_fraction) : 0,
                  .columns = std::vector<SampleSums::Column>(static_cast<size_t>(data_.width_px) *
                                                             (share_ ? 1 : data_.channels)),
                  .rows = RowOffsets(data_, sums_, share_),
                  .means = {}};
  for (size_t k = 0; k < levels_; ++k) sums.means.push_back(sum(k).mean.data());
  for (int v = 0; v < data_.height_px; ++v) {
    add_row(v, sums);
    if (columns_vary) compare_columns(v, sums);
  }
  const auto samples = static_cast<double>(data_.samples()),
             n_hot = static_cast<double>(sums.hot_samples);
  total_.log_det -= 2 * (n_hot * sums.log_hot + (samples - n_hot) * sums.log_cold);
  if (columns_vary) {
    const double variance = chain_.column_sigma_dn * chain_.column_sigma_dn;
    // Their mean over columns is taken with the rows.
    const double part = (data_.width_px - 1.0) / data_.width_px;
    for (const SampleSums::Column& column : sums.columns) {
      const double info = variance * column.info;
      total_.chi2 -= variance * column.score * column.score / (1 + info);
      total_.log_det += part * std::log1p(info);
    }
  }
  if (sums.structured) sums.rows.add(chain_, total_);
}

// The hot samples of row v, and what its samples say of the offsets of row and columns.
void CellLikelihood::add_row(int v, SampleSums& sums) {
  const bool pixels = sums.pixels, hot = sums.hot;
  const size_t channels = data_.channels;
  std::vector<double> r(levels_);
  size_t i = static_cast<size_t>(v) * data_.width_px * channels;
  for (int u = 0; u < data_.width_px; ++u) {
    for (size_t c = 0; c < channels; ++c, ++i) {
      const size_t cell = cells_.of_sample[i], at = cell * levels_;
      const double offset = cells_.offset[i];
      for (size_t k = 0; k < levels_; ++k)
        r[k] = sums.means[k][i] - entries_[at + k].mean - entries_[at + k].slope * offset;
      if (hot) {
        double along = 0;
        for (size_t k = 0; k < levels_; ++k) along += hot_vector_[at + k] * r[k];
        // A sample is hot where that is likelier; its residual is then taken from the hot mean.
        if (along - 0.5 * inverse_[cell].hot_square + sums.log_hot > sums.log_cold) {
          ++sums.hot_samples;
          total_.chi2 += inverse_[cell].hot_square - 2 * along;
          for (size_t k = 0; k < levels_; ++k) r[k] -= entries_[at + k].hot;
        }
      }
      if (!sums.structured) continue;
      double e0 = 0, e1 = 0;
      if (pixels) {
        double b0 = 0, b1 = 0;
        for (size_t k = 0; k < levels_; ++k)
          b0 += offset_load_[at + k] * r[k], b1 += gain_load_[at + k] * r[k];
        const PatternInverse& two = inverse_[cell].two;
        e0 = two.i00 * b0 + two.i01 * b1, e1 = two.i01 * b0 + two.i11 * b1;
      }
      double* score = sums.rows.score(sums.rows.unit(v, static_cast<int>(c)));
      double* precision = sums.rows.precision(sums.rows.unit(v, static_cast<int>(c)));
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
      if (sums.columns_vary) sums.columns[unit(u, static_cast<int>(c))].score += column;
    }
  }
}

// Columns beside what the samples of row v have in common.
void CellLikelihood::compare_columns(int v, SampleSums& sums) {
  const size_t channels = data_.channels;
  std::vector<std::vector<double>> common;
  for (int c = 0; c < (share_ ? 1 : data_.channels); ++c)
    common.push_back(sums.rows.estimate(sums.rows.unit(v, c)));
  size_t i = static_cast<size_t>(v) * data_.width_px * channels;
  for (int u = 0; u < data_.width_px; ++u) {
    for (size_t c = 0; c < channels; ++c, ++i) {
      const size_t cell = cells_.of_sample[i], at = cell * levels_;
      const std::vector<double>& own = common[share_ ? 0 : c];
      double along = 0;
      for (size_t k = 0; k < levels_; ++k)
        along += slope_vector_[at + k] * entries_[at + k].offset_slope * own[k];
      SampleSums::Column& column = sums.columns[unit(u, static_cast<int>(c))];
      column.score -= along;
      column.info += inverse_[cell].slope_square;
    }
  }
}

}  // namespace seam::measurement
