// Where two runs first differ. A value, never an error.
#pragma once

#include <string>

#include "sim_core/base/time.h"

namespace seam::scheduler {

struct Divergence {
  SimTime time;
  std::string section;  // "robot/red1", "ball", "frame/red1", "events", "end", "log".
  std::string field;    // "x_m"; empty where the log does not show it.
  std::string detail;   // For people.
};

}  // namespace seam::scheduler
