// The likelihood of a photometry set whose samples are sorted into cells of light
// (photometry_cells.h), in three parts: changes in time within each level (photometry_cells.cc),
// means over time with the pixels' patterns (cell_means.cc), and what rows, columns, frames and odd
// samples have of their own (cell_structure.cc).
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "effects/stages/optics.h"
#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/likelihood/photometry_cells.h"
#include "measurement/kinds/photometry/likelihood/photometry_rows.h"

namespace seam::measurement {

class CellLikelihood {
 public:
  // `share`: whether the channels have row and column offsets in common.
  CellLikelihood(const PhotometryData& data, const PhotometrySums& sums, const LightCells& cells,
                 const DarkResponses& dark, const effects::Model& model, double set_noise_dn,
                 bool share)
      : data_(data),
        sums_(sums),
        cells_(cells),
        sorted_(*cells.sorted),
        dark_(dark),
        model_(model),
        chain_(chain_before_mixing(model, data.file_bits)),
        noise_{set_noise_dn, data.least_at_top_dn2, data.least_at_bottom_dn2},
        share_(share),
        flickers_(effects::lamps_flicker(model)),
        pixels_(chain_.has_pixel_patterns()),
        levels_(sums.present.size()),
        entries_(sorted_.count() * levels_) {}

  // The log-likelihood is minus infinity where cells cannot give one; `counts` as in cell_score.
  PhotometryScore run(bool counts);

 private:
  // What a level predicts for a cell.
  struct Entry {
    double mean = 0;   // At the cell's mean light.
    double slope = 0;  // d mean / d light.
    double variance = 1, offset_slope = 1, gain_slope = 0;
    double wave = 0;                  // d mean / d wave of amplitude 1.
    std::array<double, 2> odd{0, 0};  // A hot, a weak sample's mean less that of others.
  };
  // By cell, for its samples: the inverse of their covariance between levels, in parts.
  struct Inverse {
    PatternInverse patterns;
    std::array<double, 2> odd_square{0, 0};  // h' Sigma^-1 h, h the offset of an odd sample.
    double slope_square = 0;                 // The same of the slopes by an offset.
  };
  struct Column {
    double info = 0, score = 0;
  };

  const LevelSums& sum(size_t k) const { return sums_.levels[sums_.present[k]]; }
  double frames(size_t k) const { return static_cast<double>(sum(k).frames.size()); }
  Entry& entry(size_t cell, size_t k) { return entries_[cell * levels_ + k]; }
  size_t unit(size_t place, size_t channel) const {
    return share_ ? place : place * static_cast<size_t>(data_.channels) + channel;
  }
  bool is_structured() const { return chain_.row_sigma_dn > 0 || chain_.column_sigma_dn > 0; }

  void predict_level(size_t k);
  void fill(size_t k, double illumination, double lamps, const effects::SensorExposure& exposure);
  bool rises_to(double scale) const;
  double correction(size_t k);
  template <typename F>
  std::vector<double> row_averages(size_t k, F&& value);
  double gain_scatter(size_t k, const std::vector<double>& row_gain);
  void add_changes(size_t k);
  void add_rows_of_frames(size_t k, const std::vector<double>& variance,
                          const std::vector<double>& slope2, const std::vector<double>& gain);
  void count_certain(size_t k);
  void share_among_frames();

  void add_means();
  void add_patterns(size_t cell);
  void load_patterns(size_t cell);
  void take_patterns(size_t cell, const Eigen::Matrix3d& squares);
  void add_patterns_by_sample();
  template <typename F>
  double solve(size_t cell, F&& value, double* out) const;

  void add_structure();
  void choose_odd();
  void add_residuals(const std::vector<double>& load, std::vector<double>& along) const;
  // How far an odd sample is off, over what its cell says: a weak one is so in proportion to the
  // light, which is linear within the cell.
  double odd_part(size_t i, int kind) const {
    if (kind == 0) return 1;
    return 1 + cells_.offset[i] / std::max(cells_.light[sorted_.of_sample[i]], 1e-12);
  }
  void sum_groups(const SampleGroups& groups, const PlaceSums& sums,
                  std::vector<double>& residual) const;
  void add_row_groups(const std::vector<double>& residual, RowOffsets& rows);
  void add_columns(const std::vector<double>& column_residual, const RowOffsets& rows);
  void add_lamps();

  // Of residuals from the prediction: sum over a cell's samples of r_k r_l, l <= k.
  double product(size_t cell, size_t k, size_t l) {
    const Entry &a = entry(cell, k), &b = entry(cell, l);
    const double ma = a.mean - sums_.reference[k], mb = b.mean - sums_.reference[l];
    const size_t at = cell * levels_;
    const double of_means =
        sorted_.all_products ? sorted_.products[(at + k) * levels_ + l] : sorted_.products[at + k];
    double sum = of_means - ma * sorted_.mean[at + l] - mb * sorted_.mean[at + k] +
                 sorted_.samples[cell] * ma * mb - a.slope * cells_.with_offset[at + l] -
                 b.slope * cells_.with_offset[at + k] + a.slope * b.slope * cells_.offset2[cell];
    if (a.wave == 0 && b.wave == 0) return sum;
    sum += -a.wave * cells_.with_wave[at + l] - b.wave * cells_.with_wave[at + k] +
           (a.wave * mb + b.wave * ma) * cells_.wave_sum[cell] +
           (a.wave * b.slope + b.wave * a.slope) * cells_.wave_offset[cell] +
           a.wave * b.wave * cells_.wave2[cell];
    return sum;
  }
  // Sum over a cell's samples of r_k.
  double residual_sum(size_t cell, size_t k) {
    const Entry& here = entry(cell, k);
    return sorted_.mean[cell * levels_ + k] -
           sorted_.samples[cell] * (here.mean - sums_.reference[k]) -
           here.wave * cells_.wave_sum[cell];
  }

  const PhotometryData& data_;
  const PhotometrySums& sums_;
  const LightCells& cells_;
  const SortedSamples& sorted_;
  const DarkResponses& dark_;
  const effects::Model& model_;
  effects::SensorChain chain_;
  SetNoise noise_;
  bool share_, flickers_, pixels_;
  size_t levels_;
  std::vector<Entry> entries_;
  std::optional<size_t> dark_level_;        // The first that all dark ones are like.
  std::vector<std::vector<double>> lamps_;  // By level and frame: brightness over the level's mean.
  std::vector<Inverse> inverse_;            // By cell.
  // By cell * levels + k; the loads are times the weights.
  std::vector<double> weight_, slope_vector_;
  std::vector<PatternLoads> loads_;
  std::array<std::vector<double>, 2> odd_vector_;
  std::vector<char> is_odd_;  // By sample: 0, 1 hot, 2 weak; empty: none is.
  bool falls_ = false;        // The response does within the light of a level.
  Quadratic total_;
  PhotometryScore score_;
};

}  // namespace seam::measurement
