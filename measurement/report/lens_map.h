// Maps over the image of what a lens model predicts: how well it is known, and by how much two
// models differ. Where the camera points is free in both, since unknown poses take it up: the
// rotation that makes the map smallest is taken out.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// What a computation's last digits leave moves places by less.
inline constexpr double kLeastShift_px = 1e-6;

struct LensMap {
  std::string camera;  // Empty: of the one that there is, or of all that have none of their own.
  int columns = 0, rows = 0, width_px = 0, height_px = 0;
  // By cell, row by row, at its middle, pixels; NaN where a model has no ray or no image there.
  std::vector<double> du_px, dv_px;  // Empty for errors.
  std::vector<double> size_px;       // Length of the difference, or standard error.

  // Of the cells that have one.
  double median_px() const;
  double largest_px() const;
  double largest_u_px() const;  // Where that is.
  double largest_v_px() const;
};

// One sigma of the predicted place (root of the variance along u plus that along v). One map for
// each camera with a lens of its own (effects/cameras.h).
std::vector<LensMap> error_maps(const Assessment& assessment, int width_px, int height_px);
// Where `b` sees what `a` sees at each place, less that place; a camera that either names has a
// map.
std::vector<LensMap> difference_maps(const Model& a, const Model& b, int width_px, int height_px);

// As `lens_error` of a report (docs/reference/report_data.md).
nlohmann::json maps_json(const std::vector<LensMap>& maps, const std::string& stage,
                         const std::string& title);

// "seam-models/1" and its text.
std::string models_json(const std::vector<LensMap>& maps, const std::string& a,
                        const std::string& b);
std::string models_text(const std::vector<LensMap>& maps, const std::string& a,
                        const std::string& b);

}  // namespace seam::measurement
