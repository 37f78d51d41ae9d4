// Whatever bytes a log has, reading, recovering and walking over it end in results or InputErrors.
#include "scheduler/log/log.h"

#include <google/protobuf/stubs/logging.h>

#include "scheduler/log/log_recovery.h"
#include "sim_core/base/error.h"

using namespace seam;

// Protocol Buffers would complain of every second input.
static const bool kQuiet = (google::protobuf::SetLogHandler(nullptr), true);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  for (const auto access : {scheduler::LogAccess::indexed, scheduler::LogAccess::scanned}) {
    try {
      const scheduler::Log log =
          scheduler::Log::open(std::make_unique<mcap::MemoryInput>(bytes), access);
      scheduler::LogCursor cursor(log, scheduler::kAllTopics);
      while (cursor.next()) {
      }
      log.snapshot_before(log.end_time());
      log.end();
    } catch (const InputError&) {
    }
  }
  try {
    mcap::MemoryOutput output;
    scheduler::recover_log(std::make_unique<mcap::MemoryInput>(bytes), output);
  } catch (const InputError&) {
  }
  return 0;
}
