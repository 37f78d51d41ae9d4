// The world of a log at any time: from the nearest snapshot on, with the log's commands and
// without clients, cameras or a loop.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "scheduler/log/log.h"
#include "sim_core/world/world.h"

namespace seam::scheduler {

class Rewinder {
 public:
  // `world` is one of the log's scenario, at time 0; both must outlive the rewinder. With
  // `use_snapshots` false every time is reached from the start (a log of another state version).
  Rewinder(const Log& log, World& world, bool use_snapshots = true);

  // Brings the world to the interval that holds `time`, with everything applied that acted at or
  // before it: start() <= time < end(). Times before the start count as 0; the log's end is the
  // last time. Returns the time reached.
  SimTime to(SimTime time);
  const World& world() const { return world_; }
  // Steps done since the start of the run; the step at world().start() is the last.
  uint64_t step() const { return step_; }

 private:
  struct Due {
    std::optional<Answer> answer;  // Of a robot; else an action of the supervisor.
    std::optional<SupervisorAction> action;
  };
  void restart(SimTime time);
  void read_turns_until(SimTime time);
  void apply_due(SimTime until);
  void apply(const Due& due, SimTime time);

  const Log& log_;
  World& world_;
  const bool use_snapshots_;
  std::string initial_state_;
  SimTime last_time_;
  SimTime now_;
  uint64_t step_ = 0;
  std::optional<LogCursor> turns_;
  std::optional<TurnRecord> next_turn_;
  // What acts when: (time, who, order of arrival). Supervisor actions come before robots', as in
  // the loop's total order.
  std::map<std::tuple<SimTime, int, uint64_t>, Due> due_;
  uint64_t arrivals_ = 0;
};

}  // namespace seam::scheduler
