// The mean that an evaluation's model gives a whitened residual.
#pragma once

#include "measurement/problem/evaluation.h"

namespace seam::measurement {

// 0 where errors lie on both sides alike (Evaluation::mean_square).
inline double mean_whitened(const Evaluation& evaluation, size_t scalars, size_t scalar) {
  const std::vector<double>& known = evaluation.mean_square;
  return known.size() > scalars ? known[scalars + scalar] : 0;
}

}  // namespace seam::measurement
