// Whatever records a whole chunk holds, with its CRC right: reading them, comparing and re-running
// the match by them ends in results or InputErrors. The input is the chunk's records, behind the
// header of a short match of two robots.
#include <google/protobuf/stubs/logging.h>

#include "scheduler/log/log_recovery.h"
#include "scheduler/replay/log_diff.h"
#include "scheduler/replay/log_testing.h"
#include "sim_core/base/error.h"

using namespace seam;
using namespace seam::scheduler;

namespace {

const SimTime kEnd = SimTime::from_s(0.3);

struct Match {
  Match()
      : yaml(scheduler::testing::scenario_text(SEAM_SOURCE_DIR, 2, kEnd.s())),
        scenario(Scenario::from_text(yaml, "fuzz.yaml")),
        header(scheduler::testing::header_of(scenario, yaml)),
        world(scenario),
        start(world.snapshot()) {
    mcap::MemoryOutput output;
    Recorder(output, world).on_start(header);
    file_start = output.bytes();
  }
  std::string yaml;
  Scenario scenario;
  RunHeader header;
  World world;
  std::string start;       // The world's state before its first step.
  std::string file_start;  // A log up to its header.
};

void re_run(const Log& log, Match& match) {
  match.world.restore(match.start);
  verify(log, {match.scenario, match.world, nullptr, match.header});
}

template <typename Action>
void attempt(Action action) {
  try {
    action();
  } catch (const InputError&) {
  }
}

}  // namespace

// Protocol Buffers would complain of every second input.
static const bool kQuiet = (google::protobuf::SetLogHandler(nullptr), true);

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static Match match;
  const std::string_view records(reinterpret_cast<const char*>(data), size);
  mcap::ByteSink file;
  file.raw(match.file_start);
  mcap::append(file, mcap::Chunk{0, static_cast<uint64_t>(kEnd.ns()), size, mcap::crc32(records),
                                 "", records});
  const auto open = [&] { return Log::open(std::make_unique<mcap::MemoryInput>(file.bytes())); };
  attempt([&] {
    const Log log = open();
    attempt([&] {
      LogCursor cursor(log, kAllTopics);
      while (cursor.next()) {
      }
    });
    attempt([&] { compare_logs(log, open()); });
    attempt([&] { re_run(log, match); });
    attempt([&] {
      match.world.restore(match.start);
      Rewinder rewinder(log, match.world);
      for (const double time_s : {0.1, 0.05, 0.3}) rewinder.to(SimTime::from_s(time_s));
      match.world.sections();
    });
  });
  attempt([&] {
    mcap::MemoryOutput output;
    recover_log(std::make_unique<mcap::MemoryInput>(file.bytes()), output);
  });
  return 0;
}
