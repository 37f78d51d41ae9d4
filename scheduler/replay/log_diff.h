// Two runs held against each other: where they first differ, and how that spreads.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/log.h"
#include "sim_core/body/state.h"

namespace seam::scheduler {

struct LogDifference {
  struct First {
    SimTime time;
    std::string section;
    std::string field;  // Empty until the states themselves are compared.
    std::string a, b;   // The field's values.
  };
  struct Spread {
    SimTime time;
    std::string section;  // Of the state, or "frame/ROBOT".
  };
  struct FirstDecision {
    // One run's side of it: the decision, and the newest frame that the robot had been sent by
    // then.
    struct Side {
      Answer answer;
      std::optional<FrameRecord> frame;
    };
    SimTime time;
    std::string robot;
    std::optional<Side> a, b;  // Where the robot decided at this instant in both runs.
    // What differs, by names (app/logs/decision_fields.h); a side that lacks a field has "".
    struct Field {
      std::string name, a, b;
    };
    std::vector<Field> fields;
    // Whether both decided from the same pixels; none where one had no frame.
    std::optional<bool> same_frame() const {
      if (!a || !b || !a->frame || !b->frame) return std::nullopt;
      return a->frame->index == b->frame->index && a->frame->fingerprint == b->frame->fingerprint;
    }
  };

  // Differences of what the runs depend on, as sentences: seed, scenario, files, robots.
  std::vector<std::string> header;
  // The first instant at which a robot decided otherwise: often the cause.
  std::optional<FirstDecision> first_decision;
  std::optional<First> first;
  // When each section differs for the first time, in order of time.
  std::vector<Spread> spread;
  // Both logs have records up to here.
  SimTime compared_until;
  SimTime end_a, end_b;

  // Nothing differs, where both have records; lengths and ways to end count too.
  bool equal() const {
    return header.empty() && !first_decision && spread.empty() && end_a == end_b;
  }
};

// Compares what the logs hold: hashes and decisions. `first` has no field yet.
LogDifference compare_logs(const Log& a, const Log& b);

// The state of a log after its step at this time.
using StateAt = std::function<std::vector<StateSection>(SimTime)>;
// Names the first differing field with its values, from the states of both runs.
void name_field(LogDifference& difference, const StateAt& state_a, const StateAt& state_b);

}  // namespace seam::scheduler
