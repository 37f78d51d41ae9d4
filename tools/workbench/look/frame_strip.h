// Whole images beside what a model predicts for them: of some frames of a set, small enough for a
// page.
#pragma once

#include <string>

#include "measurement/problem/problem.h"
#include "measurement/sets/set.h"

namespace seam::tools {

// A head {frames: [{line, name}], width_px, height_px, predicted} as in a table of rows; then for
// each frame red, green and blue of its pixels, as measured, or as `model` predicts them. Empty
// where the set is not one of whole images.
std::string measured_frames(const measurement::Problem& problem,
                            const measurement::MeasurementSet& set);
std::string predicted_frames(const measurement::Problem& problem,
                             const measurement::MeasurementSet& set,
                             const measurement::Model& model);

}  // namespace seam::tools
