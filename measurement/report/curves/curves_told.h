// Curves of a field's standard beside those of the model: as JSON, as text, as plots of a page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// `curves` of a result; nothing where the kind has none.
void add_curves(nlohmann::ordered_json& json, const Problem& problem, const Model& model);

// Where measured and expected curves are most standard errors apart, one a line; empty where there
// are none.
std::string curves_text(const Problem& problem, const Model& model);

// `series` of a page, on logarithmic axes; `after`: the model found, null: none.
void append_curves(const Problem& problem, const Model& before, const Model* after,
                   nlohmann::json& plots);

}  // namespace seam::measurement
