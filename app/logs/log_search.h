// When a condition holds in a log: an expression over what it holds (log_signals.h), in the
// language of models' formulas, and how long it must hold.
//
//   red1.ball_area_px == 0 for 0.5 s
//   truth.red1.ball_distance_m < 0.3 && red1.ball_area_px.age_s > 1
//   event.goal
//
// NAME.age_s is the time since the last value of NAME, since the start before the first. A
// condition is false until all else that it reads has had a value.
#pragma once

#include <string>
#include <vector>

#include "scheduler/log/log.h"

namespace seam::app {

struct LogCondition {
  std::string expression;
  SimDuration at_least;
};
// Throws UsageError for a text whose `for TIME` is none.
LogCondition condition_from(const std::string& text);

// Where it holds: from `begin` on, no longer at `end`. Both are the same where it holds at one
// instant alone, as events do.
struct LogHit {
  SimTime begin, end;
  bool until_end_of_log = false;
};

struct LogHits {
  std::vector<LogHit> hits;
  std::string robot;  // The first that the expression reads, as the log names it; may be empty.
};

// The first `most` hits, in order of time. Throws UsageError for a syntax error or an unknown name.
LogHits find_in(const scheduler::Log& log, const std::string& condition, size_t most = SIZE_MAX);

// The part of the viewer's address that shows this time: "?t=12.340&robot=red1".
std::string view_query(SimTime time, const std::string& robot);

// seam-find/1 for programs and for the viewer.
std::string to_json(const LogHits& found, const std::string& condition, int indent);

}  // namespace seam::app
