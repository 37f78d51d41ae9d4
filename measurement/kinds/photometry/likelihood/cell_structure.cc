// What rows, columns, frames and odd samples have of their own in the means over time.
#include <cmath>
#include <cstdint>

#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"
#include "measurement/kinds/photometry/likelihood/cell_solve.h"
#include "measurement/kinds/photometry/likelihood/cell_sums.h"

namespace seam::measurement {

void CellLikelihood::add_structure() {
  for (size_t kind = 0; kind < 2; ++kind) {
    if (!((kind == 0 ? chain_.hot_fraction : chain_.weak_fraction) > 0)) continue;
    odd_vector_[kind].assign(entries_.size(), 0);
    for (size_t cell = 0; cell < sorted_.count(); ++cell)
      inverse_[cell].odd_square[kind] = solve(
          cell, [&](size_t k) { return entry(cell, k).odd[kind]; },
          &odd_vector_[kind][cell * levels_]);
  }
  choose_odd();
  if (!is_structured()) return;
  for (size_t cell = 0; cell < sorted_.count(); ++cell)
    inverse_[cell].slope_square = solve(
        cell, [&](size_t k) { return entry(cell, k).offset_slope; },
        &slope_vector_[cell * levels_]);
  std::vector<double> by_row, by_column;
  sum_groups(sorted_.by_row, cells_.in_rows, by_row);
  RowOffsets rows(data_, sums_, share_, RowOffsets::has_many(levels_));
  add_row_groups(by_row, rows);
  if (chain_.column_sigma_dn > 0) {
    sum_groups(sorted_.by_column, cells_.in_columns, by_column);
    add_columns(by_column, rows);
  }
  rows.add(chain_, total_);
}

// To each sample its residuals times `load` (by cell * levels + k): what the cell says is taken out
// once for all levels.
void CellLikelihood::add_residuals(const std::vector<double>& load,
                                   std::vector<double>& along) const {
  const size_t count = sorted_.count();
  std::vector<double> mean(count, 0), slope(count, 0), wave(count, 0);
  for (size_t cell = 0; cell < count; ++cell) {
    for (size_t at = cell * levels_, k = 0; k < levels_; ++at, ++k) {
      mean[cell] += load[at] * (entries_[at].mean - sums_.reference[k]);
      slope[cell] += load[at] * entries_[at].slope;
      wave[cell] += load[at] * entries_[at].wave;
    }
  }
  for (size_t i = 0; i < along.size(); ++i) {
    const size_t cell = sorted_.of_sample[i];
    along[i] += side_by_side(&load[cell * levels_], levels_).dot(means_of(sums_, i)) -
                (mean[cell] + slope[cell] * cells_.offset[i]);
    if (!cells_.wave.empty()) along[i] -= wave[cell] * cells_.wave[i];
  }
}

// A sample is hot or weak where that is likelier; its residual is then taken from that mean.
void CellLikelihood::choose_odd() {
  const bool hot = !odd_vector_[0].empty(), weak = !odd_vector_[1].empty();
  if (!hot && !weak) return;
  const double log_share[2] = {hot ? std::log(chain_.hot_fraction) : 0,
                               weak ? std::log(chain_.weak_fraction) : 0};
  const double rest = 1 - (hot ? chain_.hot_fraction : 0) - (weak ? chain_.weak_fraction : 0);
  const double log_plain = std::log(std::max(rest, 1e-6));
  const size_t samples = sorted_.of_sample.size();
  is_odd_.assign(samples, 0);
  std::vector<double> along[2];
  for (int kind = 0; kind < 2; ++kind)
    if (!odd_vector_[kind].empty()) along[kind].assign(samples, 0);
  for (size_t kind = 0; kind < 2; ++kind)
    if (!along[kind].empty()) add_residuals(odd_vector_[kind], along[kind]);
  double logs = 0;
  for (size_t i = 0; i < samples; ++i) {
    double best = 0, own = log_plain;
    for (int kind = 0; kind < 2; ++kind) {
      if (along[kind].empty()) continue;
      const double part = odd_part(i, kind);
      const double gain = part * along[kind][i] -
                          0.5 * part * part * inverse_[sorted_.of_sample[i]].odd_square[kind];
      if (!(gain + log_share[kind] > best + own)) continue;
      best = gain, own = log_share[kind], is_odd_[i] = static_cast<char>(kind + 1);
    }
    logs += own;
    total_.chi2 -= 2 * best;
  }
  total_.log_det -= 2 * logs;
}

// Residuals summed over the samples of each group, by group * levels + k.
void CellLikelihood::sum_groups(const SampleGroups& groups, const PlaceSums& sums,
                                std::vector<double>& residual) const {
  residual = groups.mean;
  for (size_t g = 0; g < groups.count(); ++g) {
    const Entry* own = &entries_[groups.cell[g] * levels_];
    for (size_t k = 0; k < levels_; ++k)
      residual[g * levels_ + k] -= groups.samples[g] * own[k].mean + own[k].slope * sums.offset[g] +
                                   own[k].wave * sums.wave[g];
  }
  for (size_t i = 0; i < is_odd_.size(); ++i) {
    if (is_odd_[i] == 0) continue;
    const int kind = is_odd_[i] - 1;
    for (size_t k = 0; k < levels_; ++k) {
      residual[groups.of_sample[i] * levels_ + k] -=
          odd_part(i, kind) *
          entries_[sorted_.of_sample[i] * levels_ + k].odd[static_cast<size_t>(kind)];
    }
  }
}

void CellLikelihood::add_row_groups(const std::vector<double>& residual, RowOffsets& rows) {
  const SampleGroups& groups = sorted_.by_row;
  std::vector<double> solved(levels_), diagonal(levels_);
  std::vector<PatternLoads> loads(levels_);
  const bool many = RowOffsets::has_many(levels_);
  for (size_t g = 0; g < groups.count(); ++g) {
    const size_t cell = groups.cell[g], at = cell * levels_;
    const size_t own = unit(groups.place[g], static_cast<size_t>(sorted_.channel[cell]));
    solve(
        cell, [&](size_t k) { return residual[g * levels_ + k]; }, solved.data());
    double* score = rows.score(own);
    for (size_t k = 0; k < levels_; ++k) {
      const double slope = entries_[at + k].offset_slope;
      score[k] += slope * solved[k];
      rows.add_slopes(own, k, groups.samples[g], entries_[at + k].gain_slope, slope);
      diagonal[k] = slope * slope * weight_[at + k];
      loads[k] = slope * loads_[at + k];
    }
    const PatternInverse& patterns = inverse_[cell].patterns;
    const double n = groups.samples[g];
    if (many) {
      rows.add_precision(own, n, diagonal.data(), loads.data());
      continue;
    }
    double* precision = rows.precision(own);
    for (size_t k = 0; k < levels_; ++k) {
      precision[k * levels_ + k] += n * diagonal[k];
      if (!pixels_) continue;
      const PatternLoads e = n * (patterns.core * loads[k]);
      for (size_t l = 0; l < levels_; ++l) precision[k * levels_ + l] -= e.dot(loads[l]);
    }
  }
}

// Columns beside what the samples of each row have in common.
void CellLikelihood::add_columns(const std::vector<double>& column_residual,
                                 const RowOffsets& rows) {
  const auto channels = static_cast<size_t>(data_.channels);
  std::vector<Column> columns(static_cast<size_t>(data_.width_px) * (share_ ? 1 : channels));
  const SampleGroups& groups = sorted_.by_column;
  const auto column_of = [&](size_t g) {
    return unit(groups.place[g], static_cast<size_t>(sorted_.channel[groups.cell[g]]));
  };
  for (size_t g = 0; g < groups.count(); ++g) {
    const size_t cell = groups.cell[g];
    Column& column = columns[column_of(g)];
    column.info += groups.samples[g] * inverse_[cell].slope_square;
    for (size_t k = 0; k < levels_; ++k)
      column.score += slope_vector_[cell * levels_ + k] * column_residual[g * levels_ + k];
  }
  // What a sample of a row's group has in common with its row.
  const SampleGroups& in_rows = sorted_.by_row;
  std::vector<double> common(in_rows.count(), 0), own;
  size_t last = ~size_t{0};
  for (size_t g = 0; g < in_rows.count(); ++g) {
    const size_t cell = in_rows.cell[g];
    const size_t row = unit(in_rows.place[g], static_cast<size_t>(sorted_.channel[cell]));
    if (row != last) own = rows.estimate(row), last = row;
    for (size_t k = 0; k < levels_; ++k) {
      const size_t at = cell * levels_ + k;
      common[g] += slope_vector_[at] * entries_[at].offset_slope * own[k];
    }
  }
  for (size_t i = 0; i < sorted_.of_sample.size(); ++i)
    columns[column_of(groups.of_sample[i])].score -= common[in_rows.of_sample[i]];
  const double variance = chain_.column_sigma_dn * chain_.column_sigma_dn;
  // Their mean over columns is taken with the rows.
  const double part = (data_.width_px - 1.0) / data_.width_px;
  for (const Column& column : columns) {
    const double info = variance * column.info;
    total_.chi2 -= variance * column.score * column.score / (1 + info);
    total_.log_det += part * std::log1p(info);
  }
}

// The frames' own factors of light that are left in the means, where rows and columns have nothing
// of their own.
void CellLikelihood::add_lamps() {
  std::vector<double> score(levels_, 0), precision(levels_ * levels_, 0), solved(levels_);
  for (size_t cell = 0; cell < sorted_.count(); ++cell) {
    const size_t at = cell * levels_;
    const double n = sorted_.samples[cell];
    solve(
        cell, [&](size_t k) { return residual_sum(cell, k); }, solved.data());
    const PatternInverse& patterns = inverse_[cell].patterns;
    for (size_t k = 0; k < levels_; ++k) {
      const double g = entries_[at + k].gain_slope;
      score[k] += g * solved[k];
      precision[k * levels_ + k] += n * g * g * weight_[at + k];
      if (!pixels_) continue;
      const PatternLoads e = n * g * (patterns.core * loads_[at + k]);
      for (size_t l = 0; l < levels_; ++l)
        precision[k * levels_ + l] -= entries_[at + l].gain_slope * loads_[at + l].dot(e);
    }
  }
  add_lamps_to_means(sums_, chain_.lamp_sigma, score, precision, total_);
}

}  // namespace seam::measurement
