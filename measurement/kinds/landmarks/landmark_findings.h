// Which landmarks have clear errors of their own, in words.
#pragma once

#include <string>
#include <vector>

#include "measurement/kinds/landmarks/landmark_noise.h"

namespace seam::measurement {

// Of displacements and delays, as far as the model's noise has them.
std::vector<Finding> found_of(const std::vector<std::string>& landmarks,
                              const effects::Noise& noise,
                              const std::vector<Displacement>& displacements);

}  // namespace seam::measurement
