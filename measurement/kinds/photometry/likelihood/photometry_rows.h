// Parts that photometry's likelihoods share: the Woodbury identity of a sample's fixed
// patterns, what the samples of a row have in common, and what those of a frame have.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/photometry/stack/photometry_data.h"

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

// What a level's mean of a sample moves by for one deviation of the sample's fixed offset, gain and
// dark current.
using PatternLoads = Eigen::Vector3d;
inline PatternLoads pattern_loads(const effects::SensorChain& chain, const PhotometryLevel& level,
                                  double offset_slope, double gain_slope) {
  return {chain.pixel_offset_sigma_dn * offset_slope, chain.pixel_gain_sigma * gain_slope,
          chain.dark_sigma_dn_per_s * level.dark_s() * offset_slope};
}
// Inverse of 1 + A for a sample's fixed patterns, A their information in its values.
struct PatternInverse {
  Eigen::Matrix3d core = Eigen::Matrix3d::Identity();
  double log_det = 0;
};
// By level: the loads, and the inverse variance of the mean over frames.
PatternInverse pattern_inverse(const PatternLoads* loads, const double* inverse, size_t levels);

// What rows' samples say of an offset that they share, by row (and channel, where channels have
// offsets of their own) and level. Sigma is a sample's own covariance between levels, s its slopes
// by an offset. The information P of a row is a matrix of levels x levels; with many levels it is
// kept as that of samples alike, whose loads and weights are the row's averages.
class RowOffsets {
 public:
  RowOffsets(const PhotometryData& data, const PhotometrySums& sums, bool share, bool many = false);

  // Above so many levels.
  static bool has_many(size_t levels) { return levels > 24; }

  size_t unit(int row, int channel) const {
    return share_ ? row : static_cast<size_t>(row) * channels_ + channel;
  }
  // Sums over the unit's samples: s_k (Sigma^-1 r)_k.
  double* score(size_t unit) { return &score_[unit * levels_]; }
  // s_k (Sigma^-1)_kl s_l; of few levels.
  double* precision(size_t unit) { return &precision_[unit * levels_ * levels_]; }
  // The same of many: n samples of diagonal s_k^2 w_k whose loads times weights times slopes are
  // `loads`, by level.
  void add_precision(size_t unit, double n, const double* diagonal, const PatternLoads* loads);
  // n samples' slopes by a factor of the light and by an offset: how a frame's light moves a row.
  void add_slopes(size_t unit, size_t level, double n, double by_light, double by_offset) {
    by_light_[unit * levels_ + level] += n * by_light;
    by_offset_[unit * levels_ + level] += n * by_offset;
  }

  // The unit's offsets by least squares, by level: what columns are compared beside.
  std::vector<double> estimate(size_t unit) const;
  // Takes out of chi2 what is left in the means over frames of the rows' noise, of the frames' own
  // light, and of the mean of the columns' offsets.
  void add(const effects::SensorChain& chain, Quadratic& total) const;

 private:
  // A unit's information: the whole matrix of few levels, else a diagonal less
  // columns * core * columns'.
  struct Information {
    Eigen::MatrixXd few;
    Eigen::VectorXd diagonal;
    Eigen::MatrixX3d columns;
    Eigen::Matrix3d core;

    Eigen::VectorXd times(const Eigen::VectorXd& x) const;
    Eigen::MatrixXd whole() const;
  };
  Information information(size_t unit) const;
  // (P^-1 + k)^-1 of a unit, k diagonal, and log det(1 + P k).
  Information beside(size_t unit, const Eigen::VectorXd& k, double& log_det) const;
  double share_of_light(size_t unit, size_t level) const;

  int width_, height_, channels_;
  bool share_, many_;
  size_t levels_;
  std::vector<double> frames_, score_, precision_;
  // By unit * levels + k.
  std::vector<double> diagonal_, by_light_, by_offset_;
  std::vector<PatternLoads> loads_;
  std::vector<double> samples_;  // By unit.
};

// The light of each frame is off by its own factor: what the samples' means over time say of it, by
// level. `score` is g' Sigma^-1 r, `precision` g' Sigma^-1 g (levels x levels) with g the slopes by
// a factor of the light. Where rows or columns have offsets, RowOffsets does it.
void add_lamps_to_means(const PhotometrySums& sums, double lamp_sigma,
                        const std::vector<double>& score, const std::vector<double>& precision,
                        Quadratic& total);

}  // namespace seam::measurement
