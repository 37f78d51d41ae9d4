// The lens's Gaussian point spread as a separable filter.
#pragma once

#include <vector>

namespace seam::render {

// Weights from -radius to +radius, sum 1. A sampled Gaussian to at least 4 sigma; below 0.7 px, where
// samples no longer describe it, five weights with the Gaussian's second and fourth moments, exact
// for light that is a cubic over them. Empty for sigma 0.
std::vector<float> point_spread(double sigma_px);

// The radius of the above.
int point_spread_radius(double sigma_px);

}  // namespace seam::render
