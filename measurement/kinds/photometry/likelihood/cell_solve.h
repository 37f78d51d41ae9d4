// Sigma^-1 of a cell's samples, between levels.
#pragma once

#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"

namespace seam::measurement {

// Sigma^-1 of a vector over levels into `out`; returns its product with the vector.
template <typename F>
double CellLikelihood::solve(size_t cell, F&& value, double* out) const {
  const size_t at = cell * levels_;
  double e0 = 0, e1 = 0, square = 0;
  if (pixels_) {
    double b0 = 0, b1 = 0;
    for (size_t k = 0; k < levels_; ++k)
      b0 += offset_load_[at + k] * value(k), b1 += gain_load_[at + k] * value(k);
    const PatternInverse& two = inverse_[cell].two;
    e0 = two.i00 * b0 + two.i01 * b1, e1 = two.i01 * b0 + two.i11 * b1;
  }
  for (size_t k = 0; k < levels_; ++k) {
    out[k] = weight_[at + k] * value(k);
    if (pixels_) out[k] -= offset_load_[at + k] * e0 + gain_load_[at + k] * e1;
    square += out[k] * value(k);
  }
  return square;
}

}  // namespace seam::measurement
