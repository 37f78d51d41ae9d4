// Tests of the means of whole frames and of their rows against time, within levels of light.
#pragma once

#include <vector>

#include "measurement/kinds/photometry/likelihood/stack_view.h"
#include "measurement/kinds/photometry/structure/photometry_chi2.h"

namespace seam::measurement {

// Smooth functions of time, every frame a mean of its own, and waves that move over the rows.
std::vector<StructureTest> time_tests(const PhotometryView& view,
                                      const PhotometryPrediction& prediction);

}  // namespace seam::measurement
