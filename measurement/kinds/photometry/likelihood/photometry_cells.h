// The likelihood of a photometry set, fast: samples of nearly equal light share one prediction, so
// that a model is evaluated for a few hundred cells of light instead of for every sample of every
// level. Within a cell the mean is linear in the light. Equal to score_photometry but for rounding;
// what it cannot do (light that changes over rows and time) is left to that.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"

namespace seam::measurement {

// Samples of a row or a column that are of one cell.
struct SampleGroups {
  std::vector<uint32_t> of_sample;  // The group of each sample.
  // By group.
  std::vector<uint32_t> place, cell;  // Row or column, and the cell.
  std::vector<double> samples, offset, wave;
  std::vector<double> mean;  // By group * levels + k: sum of the samples' means.
  size_t count() const { return place.size(); }
};

// What is asked of cells beyond sums over them.
struct CellNeeds {
  bool products = false;  // Of means at different levels.
  bool groups = false;
};

// Samples sorted by channel and light. Levels (k) are those that have frames.
struct LightCells {
  std::vector<size_t> present;  // The levels.
  std::vector<uint16_t> of_sample;
  std::vector<float> offset;      // By sample: its light less that of its cell.
  std::vector<double> reference;  // By level: what was subtracted from `mean` and `products`.
  // By cell; cells without samples are left out.
  std::vector<int> channel;
  std::vector<double> samples;
  std::vector<double> light;      // The samples' mean.
  std::vector<double> low, high;  // Its bounds.
  std::vector<double> offset2;    // Sum of squared offsets.
  // By cell * levels + k: sums of a sample's mean over frames, of its product with the offset, of
  // its scatter.
  std::vector<double> mean, with_offset, scatter;
  // By (cell * levels + k) * levels + l, l <= k: sums of products of means; of l = k alone, by cell
  // * levels + k, where there would be too many.
  std::vector<double> products;
  bool all_products = false;
  // The wave over the image, of amplitude 1: by sample (empty: there is none), sums over each cell
  // of it, its square, its product with the offset, and by cell * levels + k with the sample's
  // mean.
  std::vector<float> wave;
  std::vector<double> wave_sum, wave2, wave_offset, with_wave;
  // Samples of one cell that stand in one row, in one column; means and columns where asked for.
  SampleGroups by_row, by_column;
  // By channel, and one more: its first cell; cells of a channel stand by ascending light.
  std::vector<size_t> first;
  std::vector<double> row_light;  // By row * channels + channel: mean.
  // By channel: the range of light.
  std::vector<double> least, most;

  size_t count() const { return channel.size(); }
};

// Sorted once for each field of light; fits move the sensor's parameters far more often.
// Thread-safe.
class CellStore {
 public:
  std::shared_ptr<const LightCells> cells(const PhotometryData& data, const PhotometrySums& sums,
                                          const effects::Model& model, CellNeeds needs) const;

 private:
  struct Entry {
    std::string key;
    CellNeeds needs;
    std::shared_ptr<const LightCells> cells;
  };
  mutable std::mutex mutex_;
  mutable std::list<Entry> entries_;  // Most recently used first.
};

// What score_photometry gives; nothing where cells cannot stand for the samples. `counts`: whether
// values that are certain are counted, which takes a look at each sample.
std::optional<PhotometryScore> cell_score(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share,
                                          bool counts = true);
// Its log-likelihood.
std::optional<double> cell_log_likelihood(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share);

}  // namespace seam::measurement
