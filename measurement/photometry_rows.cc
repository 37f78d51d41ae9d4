#include "measurement/photometry_rows.h"

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

class RowPart {
 public:
  RowPart(const RowMeans& means, const PhotometryData& data, const PhotometrySums& sums,
          const effects::SensorChain& chain, bool share)
      : means_(means), data_(data), chain_(chain), share_(share) {
    for (const LevelSums& level : sums.levels) {
      if (!level.frames.empty()) frames_.push_back(static_cast<double>(level.frames.size()));
    }
    for (auto* v : {&inverse_, &offset_, &gain_}) v->resize(frames_.size());
  }

  void add(Quadratic& total) {
    const size_t count = frames_.size();
    const size_t groups = share_ ? 1 : data_.channels;
    const double mean_column2 = chain_.column_sigma_dn * chain_.column_sigma_dn / data_.width_px;
    const double row2 = chain_.row_sigma_dn * chain_.row_sigma_dn;
    std::vector<double> info(groups, 0), score(groups, 0), p(count), system(count * count);
    std::vector<double> slope(count), matrix(count * count), x(count), y(count);
    for (int v = 0; v < data_.height_px; ++v) {
      for (size_t g = 0; g < groups; ++g) {
        precision_of_row(v, static_cast<int>(g), matrix, slope);
        const double* b = &means_.score[(static_cast<size_t>(v) * groups + g) * count];
        // (I + K P) s = b, P the diagonal of the row noise in the means.
        for (size_t k = 0; k < count; ++k) p[k] = row2 * slope[k] * slope[k] / frames_[k];
        for (size_t i = 0; i < count; ++i) {
          for (size_t k = 0; k < count; ++k)
            system[i * count + k] = (i == k) + matrix[i * count + k] * p[k];
        }
        std::copy(b, b + count, x.begin());
        for (size_t i = 0; i < count; ++i) {
          y[i] = 0;
          for (size_t k = 0; k < count; ++k) y[i] += matrix[i * count + k] * slope[k];
        }
        if (row2 > 0) total.log_det += eliminate(system, x, y);
        for (size_t k = 0; k < count; ++k) {
          total.chi2 -= b[k] * p[k] * x[k];
          score[g] += slope[k] * x[k];
          info[g] += slope[k] * y[k];
        }
      }
    }
    for (size_t g = 0; g < groups; ++g) {
      total.chi2 -= mean_column2 * score[g] * score[g] / (1 + mean_column2 * info[g]);
      total.log_det += std::log1p(mean_column2 * info[g]);
    }
  }

 private:
  // Sum over a row's samples of Sigma^-1, from the row's average sample.
  void precision_of_row(int v, int group, std::vector<double>& matrix, std::vector<double>& slope) {
    const size_t count = frames_.size();
    std::fill(matrix.begin(), matrix.end(), 0);
    std::fill(slope.begin(), slope.end(), 0);
    const int first = share_ ? 0 : group, last = share_ ? data_.channels - 1 : group;
    for (int c = first; c <= last; ++c) {
      const size_t at = (static_cast<size_t>(v) * data_.channels + c) * count;
      for (size_t k = 0; k < count; ++k) {
        inverse_[k] = 1 / means_.variance[at + k];
        offset_[k] = chain_.pixel_offset_sigma_dn * means_.slope[at + k];
        gain_[k] = chain_.pixel_gain_sigma * means_.gain[at + k];
        slope[k] += means_.slope[at + k] / (last - first + 1);
      }
      PatternInverse two;
      if (chain_.pixel_offset_sigma_dn > 0 || chain_.pixel_gain_sigma > 0)
        two = pattern_inverse(offset_.data(), gain_.data(), inverse_.data(), count);
      for (size_t i = 0; i < count; ++i) {
        for (size_t k = 0; k < count; ++k) {
          const double oi = offset_[i] * inverse_[i], gi = gain_[i] * inverse_[i];
          const double ok = offset_[k] * inverse_[k], gk = gain_[k] * inverse_[k];
          matrix[i * count + k] +=
              data_.width_px * ((i == k) * inverse_[i] - oi * (two.i00 * ok + two.i01 * gk) -
                                gi * (two.i01 * ok + two.i11 * gk));
        }
      }
    }
  }

  const RowMeans& means_;
  const PhotometryData& data_;
  const effects::SensorChain& chain_;
  bool share_;
  std::vector<double> frames_, inverse_, offset_, gain_;
};

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

void RowMeans::add(const PhotometryData& data, const PhotometrySums& sums,
                   const effects::SensorChain& chain, bool share, Quadratic& total) const {
  RowPart(*this, data, sums, chain, share).add(total);
}

}  // namespace seam::measurement
