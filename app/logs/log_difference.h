// The comparison of two logs for people and for programs.
#pragma once

#include <string>

#include "scheduler/replay/log_diff.h"

namespace seam::app {

// Compares hashes and decisions, and the states themselves at the first difference.
scheduler::LogDifference difference_of(const scheduler::Log& a, const scheduler::Log& b);
// A few lines: the first difference, its likely cause, the order in which it spreads.
std::string to_text(const scheduler::LogDifference& difference);
// seam-diff/1.
std::string to_json(const scheduler::LogDifference& difference);
// As the viewer asks for it (docs/reference/viewer_api.md).
std::string to_view_json(const scheduler::LogDifference& difference);

}  // namespace seam::app
