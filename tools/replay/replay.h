// The subcommands of `seam replay`: `tools/replay_<name>.cc` defines add_replay_<name>.
#pragma once

#include <string>

#include "app/session/run_session.h"
#include "mcap/reader.h"

namespace seam::tools {

#define SEAM_REPLAY_COMMANDS(X) \
  X(verify)                     \
  X(show)                       \
  X(find) X(diff) X(export) X(episodes) X(recover) X(frames) X(resume) X(whatif) X(feed) X(accuracy)

#define SEAM_DECLARE(name) void add_replay_##name(app::Command replay);
SEAM_REPLAY_COMMANDS(SEAM_DECLARE)
#undef SEAM_DECLARE

// Who decides in a robot's place: a program that we start, or one that the user starts.
struct StandIn {
  std::string robot, client, by_hand;

  std::string name() const { return client.empty() ? "your program" : "'" + client + "'"; }
  // Throws UsageError where neither or both are given.
  void set_up(app::SessionOptions& session) const;
};
void add_stand_in_options(app::Command command, StandIn& stand_in);

}  // namespace seam::tools
