// Tests of structure in the residuals of a photometry set (photometry_structure.cc).
#pragma once

#include <vector>

#include "measurement/kinds/photometry/likelihood/stack_view.h"

namespace seam::measurement {

// Structures with p < 0.01 after correction for the number of looks, strongest first. What the
// model's refitted parameters can absorb is taken out before each test of the mean.
std::vector<Structure> photometry_structure(const PhotometryView& view, const Model& model);

}  // namespace seam::measurement
