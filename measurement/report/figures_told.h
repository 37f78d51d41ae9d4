// Figures that follow from a model's values, with the errors that follow from those of the fit.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

std::vector<Figure> figures_told(const Problem& problem, const Assessment& assessment);

// The measured figures of a field's standard, and behind them those that the model gives instead.
// Of a camera that was calibrated its focal lengths and centre.
FigureTable figure_table(const Problem& problem, const Assessment& assessment);

// The same as "figures", where there are any.
void add_figures(nlohmann::ordered_json& json, const Problem& problem,
                 const Assessment& assessment);

// The same for people, one a line; empty where there are none.
std::string figures_text(const Problem& problem, const Assessment& assessment);

}  // namespace seam::measurement
