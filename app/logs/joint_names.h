// What the joints of a log's robots are called.
#pragma once

#include <string>
#include <vector>

#include "scheduler/log/log_records.h"

namespace seam::app {

// By robot and joint, as the log's scenario says; "joint 7" where that cannot be read or has no
// such joint, for what a log says may be wrong.
class JointNames {
 public:
  explicit JointNames(const scheduler::RunHeader& header);
  std::string of(size_t robot, int joint) const;
  // Whether it is known to have no head of tilt, pan and roll: the poses of its log then have none.
  bool lacks_head(size_t robot) const;

 private:
  std::vector<std::vector<std::string>> names_;
};

}  // namespace seam::app
