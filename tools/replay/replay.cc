// `seam replay ...`: what can be done with the log of a run. One file a subcommand.
#include "tools/replay/replay.h"

#include <fmt/format.h>

#include "tools/command.h"

namespace seam::tools {

std::string index_sentence(const mcap::Loss& damage) {
  return fmt::format("the index is damaged at offset {} ({} bytes): {}", damage.offset,
                     damage.bytes, damage.what);
}

void add_replay(app::Command app) {
  app::Command replay =
      app.add_subcommand("replay", "Verifies, shows, compares, resumes and mends logs");
  replay.require_subcommand();
#define SEAM_ADD(name) add_replay_##name(replay);
  SEAM_REPLAY_COMMANDS(SEAM_ADD)
#undef SEAM_ADD
}

}  // namespace seam::tools
