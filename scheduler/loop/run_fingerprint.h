// The fingerprint of a run: a chain over each step's section hashes and each frame's fingerprint,
// in the order in which the run reported them.
#pragma once

#include <span>

#include "sim_core/base/hash.h"

namespace seam::scheduler {

class RunFingerprint {
 public:
  void add(std::span<const uint64_t> values) {
    Hasher hasher;
    hasher.add(value_);
    for (const uint64_t value : values) hasher.add(value);
    value_ = hasher.digest();
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0;
};

}  // namespace seam::scheduler
