// The likelihood of a photometry set whose samples are sorted into cells of light
// (photometry_cells.h), in two parts: changes in time within each level (photometry_cells.cc) and
// means over time with the fixed patterns (cell_means.cc).
#pragma once

#include <vector>

#include "effects/stages/optics.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

namespace seam::measurement {

class CellLikelihood {
 public:
  // `share`: whether the channels have row and column offsets in common.
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

  // The log-likelihood; minus infinity where cells cannot give one.
  double run();

 private:
  // What a level predicts for a cell.
  struct Entry {
    double mean = 0;   // At the cell's mean light.
    double slope = 0;  // d mean / d light.
    double variance = 1, offset_slope = 1, gain_slope = 0;
    double hot = 0;  // A hot sample's mean less that of others.
  };
  // By cell, for its samples: the inverse of their covariance between levels, in parts.
  struct Inverse {
    PatternInverse two;
    double hot_square = 0;    // h' Sigma^-1 h, h the offset of a hot sample.
    double slope_square = 0;  // The same of the slopes by an offset.
  };
  struct SampleSums;  // Of the pass over all samples (cell_means.cc).

  const LevelSums& sum(size_t k) const { return sums_.levels[cells_.present[k]]; }
  double frames(size_t k) const { return static_cast<double>(sum(k).frames.size()); }
  Entry& entry(size_t cell, size_t k) { return entries_[cell * levels_ + k]; }
  size_t unit(int place, int channel) const {
    return share_ ? static_cast<size_t>(place)
                  : static_cast<size_t>(place) * data_.channels + channel;
  }

  void predict_level(size_t k);
  void fill(size_t k, double illumination, double lamps, const effects::SensorExposure& exposure);
  double correction(size_t k);
  template <typename F>
  std::vector<double> row_averages(size_t k, F&& value);
  double gain_scatter(size_t k, const std::vector<double>& row_gain);
  void add_changes(size_t k);
  void add_means();
  void add_patterns(size_t cell);
  void find_slope_products(size_t cell);
  void add_samples();
  void add_row(int v, SampleSums& sums);
  void compare_columns(int v, SampleSums& sums);

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
  std::vector<Inverse> inverse_;            // By cell.
  // By cell * levels + k.
  std::vector<double> weight_, offset_load_, gain_load_, hot_vector_, slope_vector_;
  // By (cell * levels + k) * levels + l: s_k (Sigma^-1)_kl s_l; empty without pixels' patterns.
  std::vector<double> slope_products_;
  Quadratic total_;
};

}  // namespace seam::measurement
