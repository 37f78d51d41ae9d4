// The plots of a report from residuals, as JSON (docs/reference/report_data.md, "plots").
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measurement/problem/residual_view.h"

namespace seam::measurement {

// Residuals against one covariate: bins of equal number, and some of the residuals themselves.
// Null where the view does not know the covariate or holds too few residuals.
nlohmann::json residual_plot(const ResidualView& view, const Structure& structure,
                             const std::string& stage);

// Arrows over the image where there are u and v; null elsewhere.
nlohmann::json arrow_plot(const ResidualView& view, const std::string& stage);

// Mean residual of pixel values in cells over the image; null for other residuals.
nlohmann::json image_map(const ResidualView& view, const std::string& stage);

// Residuals over their own sigma: one histogram for each of the first `channels`.
void append_histograms(const ResidualView& view, size_t channels, const std::string& stage,
                       nlohmann::json& list);

}  // namespace seam::measurement
