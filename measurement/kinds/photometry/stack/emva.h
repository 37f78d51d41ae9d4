// The figures of EMVA 1288 (release 3.1, linear cameras) from the statistics of whole frames, by
// the standard's own formulas, each with the standard error that the samples leave it.
#pragma once

#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {

// Nothing (no figures) for colour images, and without levels of light and dark frames in pairs.
FigureTable emva_figures(const PhotometryData& data);

}  // namespace seam::measurement
