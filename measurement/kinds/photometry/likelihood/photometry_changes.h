// The part of a photometry set's likelihood that is in changes in time, from every sample
// (photometry_likelihood.cc).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_model.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

namespace seam::measurement {

// Changes in time: rows' means from frame to frame, and what is left within rows.
class TemporalPart {
 public:
  TemporalPart(const PhotometryData& data, const PhotometryPrediction& prediction, bool share)
      : data_(data), prediction_(prediction), share_(share) {}

  Quadratic add(const LevelSums& sum, const LevelPrediction& level, std::vector<double>& by_frame) {
    Quadratic total;
    const size_t frames = sum.frames.size();
    // Of the means over time, whose patterns PatternPart adds, and of the changes.
    LogSum logs;
    for (const double v : level.variance) logs.add(v);
    const double log_variance = logs.total();
    total.log_det = log_variance;
    if (frames < 2) return total;
    const size_t rows = data_.rows();
    const auto width = static_cast<double>(data_.width_px);
    std::vector<double> variance(rows, 0), slope2(rows, 0), gain(rows, 0);
    const double part = 1 / width;
    each_sample([&](size_t i, size_t row) {
      variance[row] += level.variance[i] * part;
      slope2[row] += level.offset_slope[i] * level.offset_slope[i] * part;
      gain[row] += level.gain_slope[i] * part;
    });
    const double freedom = static_cast<double>(frames - 1);
    // Within rows: (frames - 1) (width - 1) degrees of freedom a row. Flicker moves a row's parts
    // in proportion to their light; what that adds to the scatter is subtracted.
    const double share = freedom * (width - 1) / width;
    std::vector<double> moved(rows, 0);
    if (prediction_.moves) {
      for (size_t row = 0; row < rows; ++row) {
        for (const auto& shift : level.row_shift) moved[row] += shift[row] * shift[row];
        moved[row] /= std::max(gain[row] * gain[row], 1e-9);
      }
    }
    total.log_det += share * log_variance;
    each_sample([&](size_t i, size_t row) {
      const double d = level.gain_slope[i] - gain[row];
      total.chi2 += (sum.scatter[i] - moved[row] * d * d) / level.variance[i];
    });
    const double spread = prediction_.chain.row_sigma_dn * prediction_.chain.row_sigma_dn;
    for (size_t f = 0; f < frames; ++f) {
      Quadratic of_frame = frame_rows(sum, level, f, variance, slope2, spread);
      const double lamp2 = prediction_.chain.lamp_sigma * prediction_.chain.lamp_sigma;
      if (lamp2 > 0) {
        // Its own factor of light beside the rows' noise.
        double score = 0, info = 0;
        for (size_t row = 0; row < rows; ++row) {
          const double own = variance[row] / width + spread * slope2[row];
          const double r =
              data_.row_mean[sum.frames[f]][row] - sum.row_mean[row] - level.row_shift[f][row];
          score += gain[row] * r / own, info += gain[row] * gain[row] / own;
        }
        of_frame.chi2 -= lamp2 * score * score / (1 + lamp2 * info);
        of_frame.log_det += std::log1p(lamp2 * info);
      }
      by_frame[sum.frames[f]] -=
          0.5 * (of_frame.chi2 + of_frame.log_det * freedom / static_cast<double>(frames));
      total.chi2 += of_frame.chi2;
      total.log_det += of_frame.log_det * freedom / static_cast<double>(frames);
    }
    return total;
  }

 private:
  template <typename F>
  void each_sample(F&& f) const {
    size_t i = 0;
    for (size_t v = 0; v < static_cast<size_t>(data_.height_px); ++v) {
      for (int u = 0; u < data_.width_px; ++u) {
        for (int c = 0; c < data_.channels; ++c, ++i) f(i, v * data_.channels + c);
      }
    }
  }

  Quadratic frame_rows(const LevelSums& sum, const LevelPrediction& level, size_t f,
                       const std::vector<double>& variance, const std::vector<double>& slope2,
                       double spread) const {
    Quadratic total;
    LogSum logs;
    const auto& means = data_.row_mean[sum.frames[f]];
    const int channels = data_.channels;
    for (size_t v = 0; v < static_cast<size_t>(data_.height_px); ++v) {
      double info = 0, score = 0;
      for (int c = 0; c < channels; ++c) {
        const size_t row = v * channels + c;
        const double own = variance[row] / data_.width_px;
        const double r = means[row] - sum.row_mean[row] - level.row_shift[f][row];
        total.chi2 += r * r / own;
        logs.add(variance[row]);
        const double load2 = spread * slope2[row];
        if (load2 == 0) continue;
        info += load2 / own;
        score += std::sqrt(load2) * r / own;
        if (share_ && c + 1 < channels) continue;
        total.chi2 -= score * score / (1 + info);
        total.log_det += std::log1p(info);
        info = score = 0;
      }
    }
    total.log_det += logs.total();
    return total;
  }

  const PhotometryData& data_;
  const PhotometryPrediction& prediction_;
  bool share_;
};

}  // namespace seam::measurement
