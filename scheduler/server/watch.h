// Values that a client with the supervisor's token gets with the turns of its robot: numbers over
// truth, logged values and events. A client with a robot's token alone never gets them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim_core/base/time.h"

namespace seam::scheduler {

// The values of one client's expressions.
class Watch {
 public:
  virtual ~Watch() = default;
  // At `now`, while the loop stands; one for each expression, NaN where it has no value yet.
  // Events are those since the last call.
  virtual std::vector<double> values(SimTime now) = 0;
};

class WatchSource {
 public:
  virtual ~WatchSource() = default;
  // For the turns of this robot. Throws UsageError for what cannot be watched.
  virtual std::shared_ptr<Watch> watch(const std::string& robot,
                                       const std::vector<std::string>& expressions) = 0;
};

}  // namespace seam::scheduler
