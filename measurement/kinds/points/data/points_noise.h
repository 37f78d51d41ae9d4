// The noise of image points when the set does not state it.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "measurement/kinds/points/data/points_data.h"
#include "measurement/kinds/points/target/rough_camera.h"

namespace seam::measurement {

// Displacements of a target's points are told from noise where so many views show them.
inline constexpr size_t kViewsTellDisplacements = 4;
// A view of fewer points says nothing of its noise.
inline constexpr size_t kPointsTellNoise = 7;

// What a camera that was fitted to the views leaves of them.
struct SeenByCamera {
  RoughCamera camera;
  std::vector<double> residual_px;  // By scalar.
};

struct PointsNoise {
  std::array<double, 2> sigma;  // Of u and of v.
  // By view: its sigma over these. Empty where views scatter alike.
  std::vector<double> of_view;
};

// A camera that sees these rows of each view.
std::optional<RoughCamera> camera_of_views(const PointsData& data,
                                           const std::vector<std::vector<int>>& rows_of_view);

// Of views of a target, without a model of the camera: what a flexible smooth field over the
// points' own coordinates leaves of each view. Scalars marked as gross take no part. Where a camera
// was fitted to the views the field is one of what that leaves, which is far smoother than the
// image of a near board before a wide lens.
PointsNoise estimate_views_noise(const PointsData& data, const std::vector<char>& gross,
                                 const SeenByCamera* seen = nullptr);

// One sigma of u and of v where the camera's motion is known: what a flexible smooth field over
// directions, joints and time leaves.
std::array<double, 2> estimate_noise_by_directions(const PointsData& data);

}  // namespace seam::measurement
