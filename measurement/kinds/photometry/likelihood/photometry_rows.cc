#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

#include <algorithm>

namespace seam::measurement {
namespace {

// Solves system x = x and system y = y in place; returns log of the determinant.
double eliminate(std::vector<double>& a, std::vector<double>& x, std::vector<double>& y) {
  const size_t n = x.size();
  double log_det = 0;
  for (size_t i = 0; i < n; ++i) {
    size_t pivot = i;
    for (size_t k = i + 1; k < n; ++k) {
      if (std::abs(a[k * n + i]) > std::abs(a[pivot * n + i])) pivot = k;
    }
    if (pivot != i) {
      for (size_t k = 0; k < n; ++k) std::swap(a[i * n + k], a[pivot * n + k]);
      std::swap(x[i], x[pivot]);
      std::swap(y[i], y[pivot]);
    }
    log_det += std::log(std::abs(a[i * n + i]));
    for (size_t row = i + 1; row < n; ++row) {
      const double factor = a[row * n + i] / a[i * n + i];
      if (factor == 0) continue;
      for (size_t k = i; k < n; ++k) a[row * n + k] -= factor * a[i * n + k];
      x[row] -= factor * x[i];
      y[row] -= factor * y[i];
    }
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; ++k) x[i] -= a[i * n + k] * x[k], y[i] -= a[i * n + k] * y[k];
    x[i] /= a[i * n + i];
    y[i] /= a[i * n + i];
  }
  return log_det;
}

}  // namespace

PatternInverse pattern_inverse(const double* offset, const double* gain, const double* inverse,
                               size_t levels) {
  double a00 = 1, a01 = 0, a11 = 1;
  for (size_t k = 0; k < levels; ++k) {
    a00 += offset[k] * offset[k] * inverse[k];
    a01 += offset[k] * gain[k] * inverse[k];
    a11 += gain[k] * gain[k] * inverse[k];
  }
  const double det = a00 * a11 - a01 * a01;
  return {a11 / det, -a01 / det, a00 / det, std::log(det)};
}

RowOffsets::RowOffsets(const PhotometryData& data, const PhotometrySums& sums, bool share,
                       bool many)
    : width_(data.width_px),
      height_(data.height_px),
      channels_(data.channels),
      share_(share),
      many_(many) {
  for (const LevelSums& level : sums.levels) {
    if (!level.frames.empty()) frames_.push_back(static_cast<double>(level.frames.size()));
  }
  levels_ = frames_.size();
  const size_t units = static_cast<size_t>(height_) * (share ? 1 : channels_);
  score_.assign(units * levels_, 0);
  if (!many) {
    precision_.assign(units * levels_ * levels_, 0);
    return;
  }
  for (auto* v : {&diagonal_, &offset_, &gain_}) v->assign(units * levels_, 0);
  columns_.resize(units);
}

void RowOffsets::add_precision(size_t unit, double n, const double* diagonal, const double* offset,
                               const double* gain, const PatternInverse& two) {
  const size_t at = unit * levels_;
  for (size_t k = 0; k < levels_; ++k) {
    diagonal_[at + k] += n * diagonal[k];
    offset_[at + k] += n * offset[k];
    gain_[at + k] += n * gain[k];
  }
  Columns& columns = columns_[unit];
  columns.samples += n;
  columns.i00 += n * two.i00, columns.i01 += n * two.i01, columns.i11 += n * two.i11;
}

double RowOffsets::solve(size_t unit, const std::vector<double>& a, const std::vector<double>& k,
                         std::vector<double>& x) const {
  if (!many_) {
    std::vector<double> system(levels_ * levels_), unused(levels_, 0);
    const double* matrix = &precision_[unit * levels_ * levels_];
    for (size_t i = 0; i < levels_; ++i) {
      for (size_t l = 0; l < levels_; ++l)
        system[i * levels_ + l] = (i == l ? a[i] : 0) + matrix[i * levels_ + l] * k[l];
    }
    return eliminate(system, x, unused);
  }
  // P = D - U Q U' with two columns U: x = A^-1 (b + U t), A = a + D k, t = Q U' k x.
  const Columns& columns = columns_[unit];
  const double n = std::max(columns.samples, 1.0);
  const double* d = &diagonal_[unit * levels_];
  const double *u0 = &offset_[unit * levels_], *u1 = &gain_[unit * levels_];
  double p0 = 0, p1 = 0, g00 = 0, g01 = 0, g11 = 0;
  LogSum logs;
  for (size_t i = 0; i < levels_; ++i) {
    const double own = a[i] + d[i] * k[i];
    logs.add(own);
    x[i] /= own;
    const double w = k[i] / own;
    p0 += u0[i] * k[i] * x[i], p1 += u1[i] * k[i] * x[i];
    g00 += u0[i] * u0[i] * w, g01 += u0[i] * u1[i] * w, g11 += u1[i] * u1[i] * w;
  }
  // Sums over the unit's samples: U counts n times, Q once.
  const double q00 = columns.i00 / (n * n), q01 = columns.i01 / (n * n),
               q11 = columns.i11 / (n * n);
  const double m00 = 1 - q00 * g00 - q01 * g01, m01 = -q00 * g01 - q01 * g11,
               m10 = -q01 * g00 - q11 * g01, m11 = 1 - q01 * g01 - q11 * g11;
  const double det = m00 * m11 - m01 * m10;
  const double r0 = q00 * p0 + q01 * p1, r1 = q01 * p0 + q11 * p1;
  const double t0 = (m11 * r0 - m01 * r1) / det, t1 = (m00 * r1 - m10 * r0) / det;
  for (size_t i = 0; i < levels_; ++i) x[i] += (u0[i] * t0 + u1[i] * t1) / (a[i] + d[i] * k[i]);
  return logs.total() + std::log(std::abs(det));
}

std::vector<double> RowOffsets::estimate(size_t unit) const {
  std::vector<double> x(&score_[unit * levels_], &score_[unit * levels_] + levels_);
  std::vector<double> ridge(levels_);
  // A level that is clipped whole says nothing.
  for (size_t k = 0; k < levels_; ++k) {
    const double own =
        many_ ? diagonal_[unit * levels_ + k] : precision_[(unit * levels_ + k) * levels_ + k];
    ridge[k] = 1e-9 * own + 1e-12;
  }
  solve(unit, ridge, std::vector<double>(levels_, 1), x);
  return x;
}

void RowOffsets::add(const effects::SensorChain& chain, Quadratic& total) const {
  const size_t groups = share_ ? 1 : channels_;
  const double mean_column2 = chain.column_sigma_dn * chain.column_sigma_dn / width_;
  const double row2 = chain.row_sigma_dn * chain.row_sigma_dn;
  std::vector<double> info(groups, 0), score(groups, 0), x(levels_), y(levels_), k(levels_);
  const std::vector<double> one(levels_, 1);
  for (size_t l = 0; l < levels_; ++l) k[l] = row2 / frames_[l];
  for (size_t unit = 0; unit < score_.size() / levels_; ++unit) {
    const double* b = &score_[unit * levels_];
    // (I + P K) x = b, K the diagonal of the row noise in the means; y likewise of P's row sums.
    x.assign(b, b + levels_);
    row_sums(unit, y);
    if (row2 > 0) {
      total.log_det += solve(unit, one, k, x);
      if (mean_column2 > 0) solve(unit, one, k, y);
    }
    for (size_t l = 0; l < levels_; ++l) {
      total.chi2 -= b[l] * k[l] * x[l];
      score[unit % groups] += x[l];
      info[unit % groups] += y[l];
    }
  }
  for (size_t g = 0; g < groups; ++g) {
    total.chi2 -= mean_column2 * score[g] * score[g] / (1 + mean_column2 * info[g]);
    total.log_det += std::log1p(mean_column2 * info[g]);
  }
}

void RowOffsets::row_sums(size_t unit, std::vector<double>& y) const {
  const size_t at = unit * levels_;
  if (!many_) {
    for (size_t i = 0; i < levels_; ++i) {
      y[i] = 0;
      for (size_t l = 0; l < levels_; ++l) y[i] += precision_[(at + i) * levels_ + l];
    }
    return;
  }
  const Columns& columns = columns_[unit];
  const double n2 = std::max(1.0, columns.samples * columns.samples);
  double u0 = 0, u1 = 0;
  for (size_t l = 0; l < levels_; ++l) u0 += offset_[at + l], u1 += gain_[at + l];
  const double t0 = (columns.i00 * u0 + columns.i01 * u1) / n2,
               t1 = (columns.i01 * u0 + columns.i11 * u1) / n2;
  for (size_t l = 0; l < levels_; ++l)
    y[l] = diagonal_[at + l] - offset_[at + l] * t0 - gain_[at + l] * t1;
}

void add_lamps_to_means(const PhotometrySums& sums, double lamp_sigma,
                        const std::vector<double>& score, const std::vector<double>& precision,
                        const std::vector<double>& row_variance, Quadratic& total) {
  const size_t n = score.size();
  std::vector<double> frames;
  for (const LevelSums& level : sums.levels)
    if (!level.frames.empty()) frames.push_back(static_cast<double>(level.frames.size()));
  // A common factor of each level, of the rows' variance alone and with that of the lamps: what the
  // second takes more than the first.
  for (const bool with_lamps : {false, true}) {
    std::vector<double> k = row_variance, x = score, unused(n, 0), system(n * n);
    for (size_t i = 0; i < n && with_lamps; ++i) k[i] += lamp_sigma * lamp_sigma / frames[i];
    for (size_t i = 0; i < n; ++i) {
      for (size_t l = 0; l < n; ++l) system[i * n + l] = (i == l) + precision[i * n + l] * k[l];
    }
    const double sign = with_lamps ? 1 : -1;
    total.log_det += sign * eliminate(system, x, unused);
    for (size_t i = 0; i < n; ++i) total.chi2 -= sign * score[i] * k[i] * x[i];
  }
}

}  // namespace seam::measurement
