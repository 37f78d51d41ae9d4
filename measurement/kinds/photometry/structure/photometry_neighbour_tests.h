// Whether pixels are alike in what a model leaves, as it should be of none: neighbours, or those of
// one row or column, in the means over the frames (dust, what leaks from pixel to pixel, rows that
// are read by two circuits), and neighbours in the noise of single frames (a filter in the camera,
// colours from a mosaic).
#pragma once

#include <vector>

#include "measurement/kinds/photometry/likelihood/stack_view.h"
#include "measurement/kinds/photometry/structure/photometry_chi2.h"

namespace seam::measurement {

// How the noise of single frames correlates along rows and along columns (0 where no neighbours are
// kept), and how seldom independent noise does so by chance.
struct NoiseLikeness {
  double along_rows = 0, along_columns = 0;
  double p_value = 1;
};
NoiseLikeness noise_likeness(const PhotometryView& view);

std::vector<StructureTest> neighbour_tests(const PhotometryView& view,
                                           const PhotometryPrediction& prediction);

}  // namespace seam::measurement
