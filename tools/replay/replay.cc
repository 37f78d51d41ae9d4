// `seam replay ...`: what can be done with the log of a run. One file a subcommand.
#include "tools/replay/replay.h"

#include "sim_core/base/error.h"
#include "tools/command.h"

namespace seam::tools {

void StandIn::set_up(app::SessionOptions& session) const {
  if (client.empty() == by_hand.empty())
    throw UsageError(
        "expected --client PROGRAM, which is started, or --by-hand FILE for one that you start "
        "yourself");
  session.commands[robot] = app::split_words(client);
  if (!client.empty() && session.commands[robot].empty())
    throw UsageError("--client: expected a command");
  if (!by_hand.empty()) session.by_hand = {robot, by_hand};
}

void add_stand_in_options(app::Command command, StandIn& stand_in) {
  command.add_option("--client", stand_in.client,
                     "The program with its arguments, as one word of the shell");
  command.add_option(
      "--by-hand", stand_in.by_hand,
      "In place of --client: you start the program yourself, as in a debugger. What\n"
      "it needs in its environment is written into this file (readable by you alone)\n"
      "as lines NAME=VALUE, for a shell and for the `envFile` of an editor");
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
