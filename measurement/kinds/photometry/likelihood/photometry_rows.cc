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

RowOffsets::RowOffsets(const PhotometryData& data, const PhotometrySums& sums, bool share)
    : width_(data.width_px), height_(data.height_px), channels_(data.channels), share_(share) {
  for (const LevelSums& level : sums.levels) {
    if (!level.frames.empty()) frames_.push_back(static_cast<double>(level.frames.size()));
  }
  levels_ = frames_.size();
  const size_t units = static_cast<size_t>(height_) * (share ? 1 : channels_);
  score_.assign(units * levels_, 0);
  precision_.assign(units * levels_ * levels_, 0);
}

std::vector<double> RowOffsets::estimate(size_t unit) const {
  std::vector<double> system(&precision_[unit * levels_ * levels_],
                             &precision_[(unit + 1) * levels_ * levels_]);
  std::vector<double> x(&score_[unit * levels_], &score_[(unit + 1) * levels_]), unused(levels_, 0);
  // A level that is clipped whole says nothing.
  for (size_t k = 0; k < levels_; ++k)
    system[k * levels_ + k] += 1e-9 * system[k * levels_ + k] + 1e-12;
  eliminate(system, x, unused);
  return x;
}

void RowOffsets::add(const effects::SensorChain& chain, Quadratic& total) const {
  const size_t groups = share_ ? 1 : channels_;
  const double mean_column2 = chain.column_sigma_dn * chain.column_sigma_dn / width_;
  const double row2 = chain.row_sigma_dn * chain.row_sigma_dn;
  std::vector<double> info(groups, 0), score(groups, 0), system(levels_ * levels_), x(levels_),
      y(levels_);
  for (size_t unit = 0; unit < score_.size() / levels_; ++unit) {
    const double* b = &score_[unit * levels_];
    const double* matrix = &precision_[unit * levels_ * levels_];
    // (I + K P) s = b, P the diagonal of the row noise in the means.
    for (size_t i = 0; i < levels_; ++i) {
      x[i] = b[i], y[i] = 0;
      for (size_t k = 0; k < levels_; ++k) {
        system[i * levels_ + k] = (i == k) + matrix[i * levels_ + k] * row2 / frames_[k];
        y[i] += matrix[i * levels_ + k];
      }
    }
    if (row2 > 0) total.log_det += eliminate(system, x, y);
    for (size_t k = 0; k < levels_; ++k) {
      total.chi2 -= b[k] * row2 / frames_[k] * x[k];
      score[unit % groups] += x[k];
      info[unit % groups] += y[k];
    }
  }
  for (size_t g = 0; g < groups; ++g) {
    total.chi2 -= mean_column2 * score[g] * score[g] / (1 + mean_column2 * info[g]);
    total.log_det += std::log1p(mean_column2 * info[g]);
  }
}

}  // namespace seam::measurement
