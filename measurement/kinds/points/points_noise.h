// The noise of image points when the set does not state it.
#pragma once

#include <array>

#include "measurement/kinds/points/points_data.h"

namespace seam::measurement {

// One sigma of u and v, without a model of the camera: what a flexible smooth field over the
// points' own coordinates (each frame by itself where poses are unknown) leaves. Scalars marked as
// gross take no part.
std::array<double, 2> estimate_points_noise(const PointsData& data,
                                            const std::vector<char>& gross = {});

}  // namespace seam::measurement
