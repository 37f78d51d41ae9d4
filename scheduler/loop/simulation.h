// The loop: advances a world through its events, in their total order, until the scenario's end.
//
// At one instant: decisions that act now are applied; the world steps; light is sampled for rows
// that are exposing; frames whose last row has ended are finished; robots whose turn it is are sent
// what they sense; and the loop waits until all of them have decided.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "scheduler/loop/decision_source.h"
#include "scheduler/loop/frame_renderer.h"
#include "scheduler/loop/observer.h"
#include "scheduler/loop/run_control.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

struct SimulationParts {
  const Scenario& scenario;
  World& world;  // At time 0.
  DecisionSource& decisions;
  RunControl& control;
  FrameRenderer* renderer = nullptr;  // None: requests for frames are counted and not answered.
  std::vector<SimulationObserver*> observers;
  RunHeader header;  // What observers get at the start.
};

struct SimulationOptions {
  std::optional<SimTime> until;  // The scenario's duration where not given; inclusive.
  // Test mode: simultaneous events are inserted in an order drawn from this seed.
  std::optional<uint64_t> permutation_seed;
  // Fills FrameJob::row_cameras, which nothing but files of frames needs.
  bool camera_at_rows = false;
  // Of the state after each step. Without them observers get no steps and the fingerprint is that
  // of frames alone: for whoever looks at decisions, a fifth of the time of a run without frames.
  bool state_hashes = true;
};

class Simulation {
 public:
  explicit Simulation(SimulationParts parts, SimulationOptions options = {});
  ~Simulation();

  // Runs to the end; observers have got everything when it returns.
  EndReason run();
  // Runs all events up to and including this time; false when the run ended before. For whoever
  // looks at the world in between; `run` goes on from there.
  bool run_to(SimTime time);

  SimTime now() const;
  // Over all state hashes and frame fingerprints so far, in order.
  uint64_t fingerprint() const;
  uint64_t steps() const;
  uint64_t frames() const;
  uint64_t decisions() const;

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace seam::scheduler
