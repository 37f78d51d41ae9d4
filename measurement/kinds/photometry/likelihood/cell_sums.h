// Sums over the samples of each cell, all levels of a sample at once.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_cells.h"

namespace seam::measurement {

// What stands side by side in memory, by level.
inline Eigen::Map<Eigen::VectorXd> side_by_side(double* first, size_t levels) {
  return {first, static_cast<Eigen::Index>(levels)};
}
inline Eigen::Map<const Eigen::VectorXd> side_by_side(const double* first, size_t levels) {
  return {first, static_cast<Eigen::Index>(levels)};
}

// A sample's means, less the reference.
inline Eigen::Map<const Eigen::VectorXd> means_of(const PhotometrySums& sums, size_t sample) {
  const size_t levels = sums.present.size();
  return side_by_side(&sums.by_sample[sample * levels], levels);
}

// By cell * levels + k: sums of the samples' means, less the reference, times their weights.
template <typename Weights>
std::vector<double> weighted_sums(const PhotometrySums& sums, const SortedSamples& cells,
                                  const Weights& weight) {
  const size_t levels = sums.present.size();
  std::vector<double> out(cells.count() * levels, 0);
  for (size_t i = 0; i < weight.size(); ++i) {
    side_by_side(&out[cells.of_sample[i] * levels], levels) +=
        static_cast<double>(weight[i]) * means_of(sums, i);
  }
  return out;
}

}  // namespace seam::measurement
