// The likelihood of a photometry set, fast: samples of nearly equal light share one prediction, so
// that a model is evaluated for a few hundred cells of light instead of for every sample of every
// level. Within a cell the mean is linear in the light. Equal to score_photometry but for rounding;
// what it cannot do (light that changes over rows and time) is left to that.
#pragma once

#include <algorithm>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "measurement/imaging/sensor_response.h"
#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"

namespace seam::measurement {

// Samples of a row or a column that are of one cell.
struct SampleGroups {
  std::vector<uint32_t> of_sample;  // The group of each sample.
  // By group.
  std::vector<uint32_t> place, cell;  // Row or column, and the cell.
  std::vector<double> samples;
  std::vector<double> mean;  // By group * levels + k: sum of the samples' means.
  size_t count() const { return place.size(); }
};

// What is asked of cells beyond sums over them.
struct CellNeeds {
  bool products = false;  // Of means at different levels.
  bool groups = false;
};

// Samples sorted into cells by channel and a field of light, and what cells know whatever the light
// is. Levels (k) are those that have frames (PhotometrySums::present).
struct SortedSamples {
  std::vector<uint16_t> of_sample;
  // By cell; cells without samples are left out.
  std::vector<int> channel;
  std::vector<double> samples;
  // The unit wave about which a cell's samples lie, where it is cut off by the file's range at some
  // level: there nothing is linear in it over its whole height. Empty: 0.
  std::vector<double> wave_centre;
  std::vector<double> below, above;  // From the samples' mean light to the cell's bounds.
  // By cell * levels + k: sums of a sample's mean over frames, less the reference, of its scatter.
  std::vector<double> mean, scatter;
  // By (cell * levels + k) * levels + l, l <= k: sums of products of means; of l = k alone, by cell
  // * levels + k, where there would be too many.
  std::vector<double> products;
  bool all_products = false;
  // Samples of one cell that stand in one row, in one column; means and columns where asked for.
  SampleGroups by_row, by_column;
  // By channel, and one more: its first cell; cells of a channel stand by ascending light.
  std::vector<size_t> first;
  std::vector<double> width;  // Of a channel's cells; 0 where it has one.

  size_t count() const { return channel.size(); }
};

// Sums over samples of a cell, or of a group of them.
struct PlaceSums {
  std::vector<double> offset, wave;
};

// Sorted samples under a field of light, which may differ a little from that they were sorted by.
struct LightCells {
  std::shared_ptr<const SortedSamples> sorted;
  std::vector<float> offset;        // By sample: its light less that of its cell.
  std::vector<double> light;        // By cell: the samples' mean.
  std::vector<double> low, high;    // By cell: its bounds.
  std::vector<double> offset2;      // By cell: sum of squared offsets.
  std::vector<double> with_offset;  // By cell * levels + k: sums of products with a sample's mean.
  // The wave over the image, of amplitude 1, less its cell's centre: by sample (empty: there is
  // none), sums over each cell of it, its square, its product with the offset, and by cell * levels
  // + k with the sample's mean.
  std::vector<float> wave;
  std::vector<double> wave_sum, wave2, wave_offset, with_wave;
  PlaceSums in_rows, in_columns;  // By group.
  std::vector<double> row_light;  // By row * channels + channel: mean.
  // By channel: the range of light.
  std::vector<double> least, most;
};

// By light, and by `wave` (of amplitude 1, by sample) where it is not empty.
SortedSamples sort_samples(const PhotometryData& data, const PhotometrySums& sums,
                           const std::vector<double>& light, const std::vector<double>& wave,
                           CellNeeds needs);

// What was worked out last, by key.
template <typename T>
class Recent {
 public:
  explicit Recent(double most_bytes) : most_bytes_(most_bytes) {}

  std::shared_ptr<const T> find(const std::string& key) {
    const std::scoped_lock lock(mutex_);
    const auto known = std::find_if(entries_.begin(), entries_.end(),
                                    [&](const Entry& entry) { return entry.key == key; });
    if (known == entries_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, known);
    return known->value;
  }
  std::shared_ptr<const T> keep(const std::string& key, T value, double bytes) {
    constexpr size_t kMost = 24;
    const std::scoped_lock lock(mutex_);
    entries_.push_front({key, std::make_shared<const T>(std::move(value)), bytes});
    auto shared = entries_.front().value;
    double sum = 0;
    size_t kept = 0;
    for (const Entry& entry : entries_) {
      sum += entry.bytes;
      if (kept > 1 && (sum > most_bytes_ || kept >= kMost)) break;
      ++kept;
    }
    entries_.resize(kept);
    return shared;
  }

 private:
  struct Entry {
    std::string key;
    std::shared_ptr<const T> value;
    double bytes = 0;
  };
  std::mutex mutex_;
  std::list<Entry> entries_;  // Most recently used first.
  double most_bytes_;
};

// Fits move a field of light by less than a cell from look to look, and the sensor's parameters far
// more often: samples are sorted by light whose parameters are rounded, and their sums corrected
// for the light itself. Samples that change cells change the likelihood by what is not linear
// within cells, which differences of a fit take for curvature: so a fit sorts by the light of the
// model from which it starts (`near`) as far as that hardly differs. Which cells a model gets
// depends on these models alone. Thread-safe.
class CellStore {
 public:
  std::shared_ptr<const LightCells> cells(const PhotometryData& data, const PhotometrySums& sums,
                                          const effects::Model& model, CellNeeds needs,
                                          const effects::Model* near = nullptr) const;
  const DarkResponses& dark_responses() const { return dark_; }

 private:
  // `by_wave`: whether the wave is cut off.
  std::shared_ptr<const SortedSamples> sorted(const PhotometryData& data,
                                              const PhotometrySums& sums,
                                              const effects::Model& model, bool by_wave,
                                              CellNeeds needs) const;

  mutable Recent<SortedSamples> sorted_{150e6};
  mutable Recent<LightCells> lit_{50e6};
  DarkResponses dark_;
};

// What score_photometry gives; nothing where cells cannot stand for the samples. `counts`: whether
// values that are certain are counted, which takes a look at each sample; `near` as in CellStore.
std::optional<PhotometryScore> cell_score(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share,
                                          bool counts = true, const effects::Model* near = nullptr);
// Its log-likelihood.
std::optional<double> cell_log_likelihood(const PhotometryData& data, const PhotometrySums& sums,
                                          const CellStore& store, const effects::Model& model,
                                          double set_noise_dn, bool channels_share,
                                          const effects::Model* near = nullptr);

}  // namespace seam::measurement
