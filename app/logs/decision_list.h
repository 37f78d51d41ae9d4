// Decisions by time, as a file that a test of a behaviour expects (seam-decisions/1), and how two
// such lists differ.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/logs/decision_fields.h"

namespace seam::app {

// What one robot decided, by simulated time.
struct DecisionList {
  std::string robot;
  std::map<SimTime, NamedTexts> decisions;
};

// One decision a line, so that tools for texts show what has changed.
std::string to_json(const DecisionList& list);
// Throws InputError naming file and field.
DecisionList decision_list_from(const std::filesystem::path& path);

struct OtherDecision {
  SimTime time;
  std::vector<DecisionField> fields;  // a: expected, b: found; "" where a side has none.
};
// In the order of time.
std::vector<OtherDecision> other_decisions(const DecisionList& expected, const DecisionList& found);

}  // namespace seam::app
