// Parts that photometry's likelihoods share: the Woodbury identity of a sample's two fixed
// patterns, and what the samples of a row have in common.
#pragma once

#include <cmath>
#include <vector>

#include "effects/sensor.h"
#include "measurement/photometry_data.h"

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

// By (row * channels + channel) * levels + level: averages over a row's samples. Levels are those
// with frames.
struct RowMeans {
  std::vector<double> variance;  // Of a sample's mean over frames.
  std::vector<double> slope;     // By an offset.
  std::vector<double> gain;      // By a relative gain.
  // Sum over the row's samples of Sigma^-1 r, Sigma their own covariance between levels; the
  // channels of a row are taken together where they share offsets.
  std::vector<double> score;

  void resize(size_t size) {
    for (auto* v : {&variance, &slope, &gain}) v->assign(size, 0);
  }
  // Row noise that is left in the means over frames, and the mean of the columns' offsets.
  void add(const PhotometryData& data, const PhotometrySums& sums,
           const effects::SensorChain& chain, bool share, Quadratic& total) const;
};

}  // namespace seam::measurement
