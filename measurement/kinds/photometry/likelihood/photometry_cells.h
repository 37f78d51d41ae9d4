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

#include "measurement/kinds/photometry/likelihood/photometry_model.h"

namespace seam::measurement {

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
  // By (cell * levels + k) * levels + l, l <= k: sums of products of means; of l = k alone where no
  // more was asked for.
  std::vector<double> products;
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
                                          const effects::Model& model, bool all_products) const;

 private:
  struct Entry {
    std::string key;
    bool all_products;
    std::shared_ptr<const LightCells> cells;
  };
  mutable std::mutex mutex_;
  mutable std::list<Entry> entries_;  // Most recently used first.
};

// Log-likelihood as score_photometry gives it; nothing where cells cannot stand for the samples.
std::optional<double> cell_log_likelihood(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share);

}  // namespace seam::measurement
