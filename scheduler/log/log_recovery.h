// A whole log from a damaged one.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mcap/io.h"
#include "mcap/reader.h"
#include "sim_core/base/time.h"

namespace seam::scheduler {

struct Recovery {
  struct Loss {
    mcap::Loss place;
    // The simulated time between what was read before and behind it.
    SimTime from;
    std::optional<SimTime> to;  // Nothing: everything from there on.
  };
  uint64_t messages = 0;
  uint64_t chunks = 0;
  uint64_t attachments = 0;
  // Messages of channels whose definition is lost, and which no convention gives.
  uint64_t unknown_messages = 0;
  std::vector<Loss> losses;  // Indexes that could be made anew do not count.
  // What is damaged of the index, which is written anew: nothing is lost by it.
  std::optional<mcap::Loss> index;
  // What stands behind the file's end, for instance another log: it is not copied.
  std::optional<mcap::Loss> behind_end;
  bool whole() const { return losses.empty() && unknown_messages == 0 && !behind_end; }
};

// Copies everything that can be read to `output`, with a new index. Throws InputError where nothing
// can be read.
Recovery recover_log(std::unique_ptr<mcap::Input> input, mcap::Output& output);

}  // namespace seam::scheduler
