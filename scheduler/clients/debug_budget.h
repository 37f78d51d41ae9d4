// What a robot may log (log_value, log_text, log_drawing): so many bytes a simulated second, so
// that no client fills the disk. Counted by simulated time, the same decisions are refused in each
// run.
#pragma once

#include <algorithm>
#include <cstdint>

#include "scheduler/loop/exchange.h"

namespace seam::scheduler {

class DebugBudget {
 public:
  static constexpr int64_t kBytesPerSecond = 256 << 10;

  // False, with nothing spent, where these items are more than is left at this time.
  bool spend(SimTime now, const std::vector<DebugItem>& items) {
    left_ = std::min(kMost, left_ + (now - at_).s() * kBytesPerSecond);
    at_ = now;
    double bytes = 0;
    for (const DebugItem& item : items) {
      bytes += kItemBytes + static_cast<double>(item.name.size() + item.text.size() +
                                                sizeof(double) * item.points.size());
    }
    if (bytes > left_) return false;
    left_ -= bytes;
    return true;
  }

 private:
  static constexpr double kItemBytes = 16;          // Of an item with nothing in it.
  static constexpr double kMost = kBytesPerSecond;  // What a silent robot saves up.

  double left_ = kMost;
  SimTime at_;
};

}  // namespace seam::scheduler
