// Many runs by the worker processes of sweeps, some at a time, resumed after an interruption: a run
// whose log is there and was made from the same scenario by the same behaviours is not made again.
// Results do not depend on the order.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim_core/base/time.h"
#include "sim_core/scenario/scenario.h"

namespace seam::tools {

struct PlannedRun {
  std::string name;  // Unique; names the log.
  Scenario scenario;
};

// Makes the logs `folder/NAME.mcap` that are missing; `parallel` runs at a time. Shows progress on
// a terminal. Throws InputError naming the run that failed and why.
void make_runs(const std::vector<PlannedRun>& runs, const std::filesystem::path& folder,
               int parallel);

// What a robot's behaviour logged with `log_value`, by name, in order of time.
struct LoggedValue {
  SimTime time;
  double value;
};
using LoggedValues = std::map<std::string, std::vector<LoggedValue>>;
LoggedValues logged_values(const std::filesystem::path& log, int robot = 0);

}  // namespace seam::tools
