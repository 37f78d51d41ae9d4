// Groups of residuals that scatter unlike: pictures of which some are blurred, or show the target
// from further away.
#pragma once

#include <vector>

namespace seam::measurement {

struct ResidualGroup {
  std::vector<double> values;
  double freedom = 0;  // Of their sum of squares: values less what was fitted to them.
};

// By group: its sigma over the typical one, drawn towards 1 by what chance makes of a sigma of so
// many values (an empirical Bayes estimate: logarithms of variances from a normal distribution).
// Empty where groups differ by no more than chance, or where values have spreads of their own.
std::vector<double> spreads_of_groups(const std::vector<ResidualGroup>& groups);

}  // namespace seam::measurement
