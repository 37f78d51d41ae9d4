// The lens's Gaussian point spread as a separable filter.
#pragma once

#include <vector>

#include "effects/stages/optics.h"

namespace seam::render {

// Below this sigma, samples of a Gaussian no longer describe it.
inline constexpr double kLeastSampledSigma_px = 0.7;

// Weights from -radius to +radius, sum 1. A sampled Gaussian to at least 4 sigma, or over the
// window that the model asks for (the paper's 5x5); below kLeastSampledSigma_px five weights with
// the Gaussian's second and fourth moments, exact for light that is a cubic over them. Empty for
// sigma 0.
std::vector<float> point_spread(const effects::Optics& optics);

}  // namespace seam::render
