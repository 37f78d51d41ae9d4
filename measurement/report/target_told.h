// The points of a target where a model places them: as text, JSON, a table for other sets, and a
// picture.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "measurement/problem/problem.h"

namespace seam::measurement {

// A few lines; empty where the model leaves the target at its plan.
std::string target_text(const Problem& problem, const Model& model);

// {"points": [{point, x_m, y_m, z_m, dx_m, dy_m, dz_m, sigma_dx_m, ...}]} under "target".
void add_target(nlohmann::ordered_json& json, const Problem& problem, const Model& model);

// A table point,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m of the places found, which other sets
// take with --target. Throws InputError where the model places none.
std::string target_table(const Problem& problem, const Model& model);

// Arrows over the board for a report: [x, y, dx, dy, dz] in m.
nlohmann::json target_arrows(const Problem& problem, const Model& model);

}  // namespace seam::measurement
