// How far the residuals of one channel go beyond their errors: what tells a misfit that has no
// order.
#pragma once

#include "measurement/problem/evaluation.h"

namespace seam::measurement {

struct ChannelMisfit {
  double count = 0;      // Residuals that take part.
  double sigma2 = 0;     // Sum of the squares of their errors,
  double residual2 = 0;  // of themselves,
  double chi2 = 0;       // and of their ratios.

  // Of a chi-square at least as large.
  double p_value() const;
  // Root mean square of the part beyond the errors.
  double strength() const;
};

ChannelMisfit misfit_of_channel(const Facts& facts, const Evaluation& evaluation, size_t channel);

}  // namespace seam::measurement
