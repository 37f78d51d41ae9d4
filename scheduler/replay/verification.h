// The whole check of a log: it is re-run and compared, and what no re-run can notice is audited.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scheduler/log/log.h"
#include "scheduler/loop/frame_renderer.h"
#include "scheduler/loop/observer.h"
#include "scheduler/replay/divergence.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

struct Verification {
  std::optional<Divergence> divergence;
  uint64_t steps = 0;
  uint64_t frames = 0;
  SimTime until;         // Up to here all was compared.
  bool has_end = false;  // The log does not just break off.
  // What of the log was not compared: sentences for people. Empty: everything was.
  std::vector<std::string> not_compared;
};

// The log's match at time 0, made from its header.
struct ReRun {
  const Scenario& scenario;
  World& world;
  FrameRenderer* renderer = nullptr;  // None: the frames are not compared.
  RunHeader header;
};

// `log` must be open with LogAccess::scanned. Throws InputError for what cannot be read.
Verification verify(const Log& log, ReRun match);

}  // namespace seam::scheduler
