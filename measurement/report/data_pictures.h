// Pictures of the data by kind, as JSON (docs/reference/report_data.md, "plots"): servo tracks
// beside their predictions, walks from above, landmarks with the residuals of their observations.
#pragma once

#include <nlohmann/json.hpp>

#include "measurement/problem/residual_view.h"
#include "measurement/sets/set.h"

namespace seam::measurement {

// `before` holds the residuals of the model given, `after` those of the model found or null.
// Adds nothing for kinds that have other pictures.
void append_data_pictures(const Problem& problem, const MeasurementSet& set,
                          const ResidualView& before, const ResidualView* after,
                          nlohmann::json& plots);

}  // namespace seam::measurement
