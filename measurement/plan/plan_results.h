// A plan as text, JSON (seam-plan/1) and a page.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/plan/changes.h"
#include "measurement/plan/plan.h"

namespace seam::measurement {

struct ChangedPlan {
  ProtocolChange change;
  Plan plan;
};

// A change by which the data distinguish two effects, at a size of the first.
struct Improvement {
  std::string what;
  double repeats = 1;  // As often is the changed protocol measured.
  double cost = 1;     // All of it, as a multiple of the protocol.
};
struct Improved {
  std::string effect, other;
  double size = 0;                        // Of the first parameter of `effect`.
  std::vector<Improvement> improvements;  // Cheapest first; those that part them.
  std::string advice;                     // What else would; may be empty.
};

struct WholePlan {
  std::string title, kind;
  Plan plan;
  std::vector<ChangedPlan> changes;
  std::optional<Improved> improved;
};

std::string plan_text(const WholePlan& whole);
std::string plan_json(const WholePlan& whole);
// The document of a report page.
std::string plan_report(const WholePlan& whole, const std::string& command);

}  // namespace seam::measurement
