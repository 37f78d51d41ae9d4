// Two decisions that differ, field by field with names.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "app/logs/joint_names.h"
#include "scheduler/replay/log_diff.h"

namespace seam::app {

// Names and values as texts.
using NamedTexts = std::vector<std::pair<std::string, std::string>>;
using DecisionField = scheduler::LogDifference::FirstDecision::Field;

// The fields in which two decisions of one robot differ ("pan_rad", "walk.vx_m_s", "kick"), in the
// order of docs/reference/sdk.md; then the client's values and texts ("logged.ball_area_px").
std::vector<DecisionField> other_fields(const scheduler::Answer& a, const scheduler::Answer& b,
                                        const JointNames& joints);

// What a decision orders, by the same names; what it only logs is left out.
NamedTexts orders_of(const scheduler::Answer& answer, const JointNames& joints);
std::vector<DecisionField> other_fields(const NamedTexts& a, const NamedTexts& b);

// The fields beside each other, a line each, numbers to as many digits as differ.
std::string to_text(const std::vector<DecisionField>& fields);

}  // namespace seam::app
