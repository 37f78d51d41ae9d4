// A hash over all of a log that came from outside, which no re-run can make again: the header, the
// decisions with what clients said beside them, the faults, when and why the run ended. It shows a
// change, not a forger: who changes a log can make it anew. Against forgers a log is signed.
#pragma once

#include <string_view>

#include "scheduler/log/log_records.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler {

// Takes the bytes of messages as they stand in the file, in their order. Turns and faults are
// hashed apart, since other writers may order records of one instant otherwise.
class InputsHash {
 public:
  // Records of other kinds, and later copies of the header, do not count.
  void add(const LogRecord& record, std::string_view bytes);
  uint64_t digest(SimTime end, EndReason reason) const;

 private:
  bool has_header_ = false;
  Hasher header_, turns_, faults_;
};

}  // namespace seam::scheduler
