// Whoever wants to know what happens in a run: the recorder, the verifier, progress, frame files.
// All calls come from the loop's thread, in the order of simulated time, the same in every run.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scheduler/loop/exchange.h"
#include "sim_core/base/time.h"
#include "sim_core/body/state.h"
#include "sim_core/scene/frame.h"

namespace seam::scheduler {

// Which events a run has, in RunHeader::versions; logs without it have kOldTouch instead of
// contacts that begin and end.
inline constexpr const char* kEventsKey = "events";
inline constexpr const char* kEventsVersion = "2";

// What a run depends on, and so all that a re-run needs beside the decisions.
struct RunHeader {
  std::string scenario_text;  // The scenario file's text, and the name that errors call it by.
  std::string scenario_name;
  uint64_t seed = 0;
  std::vector<std::pair<std::string, std::string>> versions;  // Program, format, libraries.
  std::vector<std::string> robots;                            // In the scenario's order.
  std::vector<std::string> sections;                          // Names of the state's hash sections.
};

enum class EndReason : uint8_t { finished, stopped, aborted };

class SimulationObserver {
 public:
  virtual ~SimulationObserver() = default;

  virtual void on_start(const RunHeader&) {}
  // What a robot's client gets, just before it is sent.
  virtual void on_observation(const Observation&) {}
  // The answers to the observations of one instant and what the supervisor did: all that a re-run
  // needs. Policies (frozen, resumed, abort) are the answers' outcomes and come as events too.
  virtual void on_turn(SimTime, const Turn&) {}
  // After each step of the world; sections are in the order of RunHeader::sections.
  virtual void on_step(SimTime, uint64_t /*step*/, const StateDigest&) {}
  // A finished frame, at the simulated time at which its last row ended; frame.fingerprint is set.
  // `job` holds the camera's pose at each light-sampling instant.
  virtual void on_frame(SimTime, const FrameJob&, const Frame&) {}
  virtual void on_event(const SimulationEvent&) {}
  virtual void on_end(SimTime, EndReason, uint64_t /*fingerprint*/) {}
};

}  // namespace seam::scheduler
