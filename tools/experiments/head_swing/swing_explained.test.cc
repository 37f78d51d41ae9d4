#include "tools/experiments/head_swing/swing_explained.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam::tools {
namespace {

// Sightings of all beacons as a robot that stands at `there` would get them that believes to be at
// `believed`.
std::vector<Sighting> sightings(const Pose2& believed, const Pose2& there) {
  std::vector<Sighting> all;
  for (int b = 0; b < kBeacons; ++b) {
    const auto from = [&](const Pose2& pose) {
      const double dx = kBeaconPlaces[b].x_m - pose.x_m, dy = kBeaconPlaces[b].y_m - pose.y_m;
      return std::pair{std::atan2(dy, dx) - pose.theta_rad, std::hypot(dx, dy)};
    };
    const auto [bearing, range] = from(there);
    const auto [true_bearing, true_range] = from(believed);
    all.push_back({.landmark = b,
                   .bearing_error_rad = bearing - true_bearing,
                   .range_error = range / true_range - 1});
  }
  return all;
}

TEST(ExplainedOffset, FindsASmallDisplacement) {
  const Pose2 truth{0.4, -0.3, 0.5};
  const PositionOffset found =
      explained_offset(sightings(truth, {0.402, -0.303, 0.501}), truth, true, true);
  EXPECT_NEAR(found.dx_mm, 2, 0.05);
  EXPECT_NEAR(found.dy_mm, -3, 0.05);
}

TEST(ExplainedOffset, PartsAddUp) {
  const Pose2 truth{1, 0.5, -0.785};
  const auto seen = sightings(truth, {1.01, 0.48, -0.78});
  const PositionOffset all = explained_offset(seen, truth, true, true);
  const PositionOffset bearings = explained_offset(seen, truth, true, false),
                       ranges = explained_offset(seen, truth, false, true);
  EXPECT_NEAR(all.dx_mm, bearings.dx_mm + ranges.dx_mm, 1e-9);
  EXPECT_NEAR(all.dy_mm, bearings.dy_mm + ranges.dy_mm, 1e-9);
}

TEST(ExplainedOffset, NothingSeenExplainsNothing) {
  EXPECT_EQ(explained_offset({}, {0, 0, 0}, true, true).dx_mm, 0);
}

}  // namespace
}  // namespace seam::tools
