// Sums over the samples of each cell at several levels at once: neighbours are often of one cell,
// whose sums would wait for each other.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {

constexpr size_t kLevelsAtOnce = 4;

// Levels from k on; the last of the first `levels` again where there are fewer.
struct SomeLevels {
  std::array<const double*, kLevelsAtOnce> seen{}, scatter{};
  std::array<double, kLevelsAtOnce> reference{};

  SomeLevels(const PhotometrySums& sums, const SortedSamples& cells, size_t k, size_t levels) {
    for (size_t j = 0; j < kLevelsAtOnce; ++j) {
      const size_t level = std::min(k + j, levels - 1);
      seen[j] = sums.levels[cells.present[level]].mean.data();
      scatter[j] = sums.levels[cells.present[level]].scatter.data();
      reference[j] = cells.reference[level];
    }
  }
};

// By cell * levels + k: sums of the samples' means, less the reference, times their weights, of the
// first `levels`.
template <typename Weights>
std::vector<double> weighted_sums(const PhotometrySums& sums, const SortedSamples& cells,
                                  const Weights& weight, size_t levels) {
  const size_t count = cells.count();
  std::vector<double> out(count * levels, 0);
  for (size_t k = 0; k < levels; k += kLevelsAtOnce) {
    const SomeLevels some(sums, cells, k, levels);
    std::vector<std::array<double, kLevelsAtOnce>> own(count, {0, 0, 0, 0});
    for (size_t i = 0; i < weight.size(); ++i) {
      std::array<double, kLevelsAtOnce>& cell = own[cells.of_sample[i]];
      for (size_t j = 0; j < kLevelsAtOnce; ++j)
        cell[j] += (some.seen[j][i] - some.reference[j]) * weight[i];
    }
    for (size_t cell = 0; cell < count; ++cell) {
      for (size_t j = 0; j < kLevelsAtOnce && k + j < levels; ++j)
        out[cell * levels + k + j] = own[cell][j];
    }
  }
  return out;
}

}  // namespace seam::measurement
