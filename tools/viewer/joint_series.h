// Joints of robots whose logs hold no angles, those without a head of tilt, pan and roll.
#pragma once

#include "app/logs/replay_match.h"
#include "tools/viewer/view_index.h"

namespace seam::tools {

// Adds "NAME_rad" to the series of each such robot, and its camera's places, at the times of its
// poses, by running the log's world again; returns at once where there is none.
void add_joint_series(app::ReplayMatch& match, ViewIndex& index);

}  // namespace seam::tools
