// The noise of image points when the set does not state it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "measurement/kinds/points/points_data.h"
#include "measurement/kinds/points/target/rough_camera.h"

namespace seam::measurement {

// What a camera that was fitted to the views leaves of them.
struct SeenByCamera {
  RoughCamera camera;
  std::vector<double> residual_px;  // By scalar.
};

// One sigma of u and v, without a model of the camera: what a flexible smooth field over the
// points' own coordinates (each frame by itself where poses are unknown) leaves. Scalars marked as
// gross take no part.
std::array<double, 2> estimate_points_noise(const PointsData& data,
                                            const std::vector<char>& gross = {});

// A camera that sees these rows of each view.
std::optional<RoughCamera> camera_of_views(const PointsData& data,
                                           const std::vector<std::vector<int>>& rows_of_view);

// The same of views of a target where a camera was fitted to them. The field is then one of what
// that leaves, which is far smoother than the image of a near board before a wide lens.
std::array<double, 2> estimate_views_noise(const PointsData& data, const std::vector<char>& gross,
                                           const SeenByCamera& seen);

}  // namespace seam::measurement
