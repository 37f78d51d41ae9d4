// How much of a position's bias the errors of the sightings explain: to first order, the pose that
// fits a run's sightings best, weighed as the localisation weighs them, when each errs as it did.
#pragma once

#include "tools/experiments/head_swing/swing_runs.h"

namespace seam::tools {

struct PositionOffset {
  double dx_mm = 0, dy_mm = 0;
};

// Errors of bearings or of ranges may be taken for zero: what is left is the others' part. They
// weigh as before.
PositionOffset explained_offset(const std::vector<Sighting>& sightings, const Pose2& truth,
                                bool bearings, bool ranges);

}  // namespace seam::tools
