// Effects of a head's encoders: one value for each of tilt, pan and roll.
#pragma once

#include <string>
#include <vector>

#include "effects/effect.h"
#include "effects/stages/joint_track.h"

namespace seam::effects {

// A parameter for each joint, its name and help with the joint's name before and inside.
inline std::vector<Parameter> head_joint_parameters(const std::string& unit,
                                                    const std::string& before,
                                                    const std::string& behind) {
  std::vector<Parameter> parameters;
  for (const std::string joint : {"tilt", "pan", "roll"}) {  // In the order of JointRole.
    parameters.push_back({.name = joint + unit,
                          .min = -0.5,
                          .max = 0.5,
                          .scale = 0.01,
                          .help = before + joint + behind});
  }
  return parameters;
}

// Changes each logged angle by its joint's value; a value of 0 changes nothing.
template <typename Change>
void change_head_angles(Values p, JointTrack& track, const Change& change) {
  for (JointSeries& joint : track.joints) {
    if (joint.role == JointRole::other) continue;
    const double value = p[static_cast<int>(joint.role)];
    if (value == 0) continue;
    for (double& q : joint.q_rad) change(q, value);
  }
}

}  // namespace seam::effects
