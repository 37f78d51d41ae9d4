// Parts that photometry's likelihoods share: the Woodbury identity of a sample's two fixed
// patterns, and what the samples of a row have in common.
#pragma once

#include <cmath>
#include <vector>

#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/photometry/likelihood/photometry_data.h"

namespace seam::measurement {

// r' S^-1 r and log det S.
struct Quadratic {
  double chi2 = 0;
  double log_det = 0;
};

// Sum of logarithms, one call of log for several values.
class LogSum {
 public:
  void add(double value) {
    product_ *= value;
    if (product_ > 1e100 || product_ < 1e-100) flush();
  }
  double total() {
    flush();
    return sum_;
  }

 private:
  void flush() {
    sum_ += std::log(product_);
    product_ = 1;
  }
  double product_ = 1, sum_ = 0;
};

// Inverse of 1 + A for a sample's gain and offset, A their information in its values.
struct PatternInverse {
  double i00 = 1, i01 = 0, i11 = 1, log_det = 0;
};
// By level: the loads of offset and gain, and the inverse variance of the mean over frames.
PatternInverse pattern_inverse(const double* offset, const double* gain, const double* inverse,
                               size_t levels);

// What rows' samples say of an offset that they share, by row (and channel, where channels have
// offsets of their own) and level. Sigma is a sample's own covariance between levels, s its slopes
// by an offset.
class RowOffsets {
 public:
  RowOffsets(const PhotometryData& data, const PhotometrySums& sums, bool share);

  size_t unit(int row, int channel) const {
    return share_ ? row : static_cast<size_t>(row) * channels_ + channel;
  }
  // Sums over the unit's samples: s_k (Sigma^-1 r)_k.
  double* score(size_t unit) { return &score_[unit * levels_]; }
  // s_k (Sigma^-1)_kl s_l.
  double* precision(size_t unit) { return &precision_[unit * levels_ * levels_]; }

  // The unit's offsets by least squares, by level: what columns are compared beside.
  std::vector<double> estimate(size_t unit) const;
  // Takes row noise that is left in the means over frames, and the mean of the columns' offsets,
  // out of chi2.
  void add(const effects::SensorChain& chain, Quadratic& total) const;

 private:
  int width_, height_, channels_;
  bool share_;
  size_t levels_;
  std::vector<double> frames_, score_, precision_;
};

}  // namespace seam::measurement
