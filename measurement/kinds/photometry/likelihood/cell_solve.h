// Sigma^-1 of a cell's samples, between levels.
#pragma once

#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"

namespace seam::measurement {

// Sigma^-1 of a vector over levels into `out`; returns its product with the vector.
template <typename F>
double CellLikelihood::solve(size_t cell, F&& value, double* out) const {
  const size_t at = cell * levels_;
  PatternLoads e = PatternLoads::Zero();
  double square = 0;
  if (pixels_) {
    for (size_t k = 0; k < levels_; ++k) e += value(k) * loads_[at + k];
    e = (inverse_[cell].patterns.core * e).eval();
  }
  for (size_t k = 0; k < levels_; ++k) {
    out[k] = weight_[at + k] * value(k);
    if (pixels_) out[k] -= loads_[at + k].dot(e);
    square += out[k] * value(k);
  }
  return square;
}

}  // namespace seam::measurement
