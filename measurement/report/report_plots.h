// The plots of a report from residuals, as JSON (docs/reference/report_data.md, "plots").
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "measurement/problem/residual_view.h"

namespace seam::measurement {

// Six digits are more than a plot shows; null for what JSON cannot write.
nlohmann::json six_digits(double value);

// At most `most` of `count` indices in order, one of each k drawn by lot: rows repeat (a board's
// corners in each frame), and every k-th one may be always the same few.
std::vector<size_t> some_of(size_t count, size_t most);

// Residuals against one covariate: bins of equal number, and some of the residuals themselves.
// Null where the view does not know the covariate or holds too few residuals. `tested`: strength
// and p of the structure were found in these residuals; those of another model say nothing here.
nlohmann::json residual_plot(const ResidualView& view, const Structure& structure, bool tested,
                             const std::string& stage);

// Arrows over the image where there are u and v; null elsewhere.
nlohmann::json arrow_plot(const ResidualView& view, const std::string& stage);

// Mean residual of pixel values in cells over the image; null for other residuals.
nlohmann::json image_map(const ResidualView& view, const std::string& stage);

// Residuals over their own sigma: one histogram for each of the first `channels`.
void append_histograms(const ResidualView& view, size_t channels, const std::string& stage,
                       nlohmann::json& list);

}  // namespace seam::measurement
