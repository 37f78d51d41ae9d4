// Whether the known points that a view shows fix its pose. Points on one line do not: the view may
// turn about the line, and neither its handedness nor the camera follows from it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/sets/set.h"
#include "sim_core/base/pose.h"

namespace seam::measurement {

// Root mean square distances of points from their middle, and from the line that fits them best.
struct PointSpread {
  double length = 0;
  double width = 0;
};
PointSpread spread_of(const std::vector<Vec3>& points);

// Three points have up to four poses, and nothing that checks them.
inline constexpr size_t kPointsOfPose = 4;

// The noise of image points that the set states (by channel or by row); nothing where it does not.
std::optional<double> stated_noise_px(const MeasurementSet& set, const CsvTable& table);

// Why the points of a view do not fix its pose, in words that follow "it shows"; empty where they
// do. `image_px`: u, v, 0. A width counts as none where noise of the image could have made it.
std::string why_no_pose(const std::vector<Vec3>& points_m, const std::vector<Vec3>& image_px,
                        std::optional<double> noise_px);

}  // namespace seam::measurement
