// Tests of the variance in time of a photometry set's samples against place and level.
#pragma once

#include <vector>

#include "measurement/kinds/photometry/likelihood/stack_view.h"
#include "measurement/kinds/photometry/structure/photometry_chi2.h"

namespace seam::measurement {

std::vector<StructureTest> spread_tests(const PhotometryView& view,
                                        const PhotometryPrediction& prediction);

}  // namespace seam::measurement
