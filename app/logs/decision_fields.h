// Two decisions that differ, field by field with names.
#pragma once

#include <vector>

#include "app/logs/joint_names.h"
#include "scheduler/replay/log_diff.h"

namespace seam::app {

using DecisionField = scheduler::LogDifference::FirstDecision::Field;

// The fields in which two decisions of one robot differ ("pan_rad", "walk.vx_m_s", "kick"), in the
// order of docs/reference/sdk.md; then the client's values and texts ("logged.ball_area_px").
std::vector<DecisionField> other_fields(const scheduler::Answer& a, const scheduler::Answer& b,
                                        const JointNames& joints);

}  // namespace seam::app
