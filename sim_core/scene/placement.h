// Where a thing stands and how it is turned, as `pose:` says it of meshes and boards.
#pragma once

#include "sim_core/base/pose.h"
#include "sim_core/input/config_table.h"

namespace seam {

struct Placement {
  Vec3 place_m{0.0};
  Vec3 roll_pitch_yaw_rad{0.0};  // Turns about x, then y, then z.

  Pose pose() const {
    return {rotation_zyx(roll_pitch_yaw_rad.x, roll_pitch_yaw_rad.y, roll_pitch_yaw_rad.z),
            place_m};
  }
};

void describe(ConfigTable& table, Placement& placement);

}  // namespace seam
