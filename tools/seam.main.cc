// The `seam` command.
#include <google/protobuf/stubs/logging.h>

#include "app/plugins.h"
#include "seam_built_from.h"
#include "tools/command.h"
#include "tools/program.h"

int main(int argc, char** argv) {
  return seam::tools::run_program("seam", [&] {
    // A bad message from a client or a log is answered by an error of ours; the library's own lines
    // would let anybody fill the terminal.
    google::protobuf::SetLogHandler(nullptr);
    // For the help alone: load_plugins takes them out of the line, since options may name their
    // effects.
    std::vector<std::string> plugins;
    return seam::app::parse_and_run(
        "SEAM: simulator of environment and measurement", "seam", "seam " SEAM_BUILT_FROM,
        seam::app::load_plugins({argv + 1, argv + argc}), [&plugins](seam::app::Command app) {
          app.require_subcommand();
          app.add_option("--plugin", plugins,
                         "Loads effects from this shared object; anywhere in the line");
#define SEAM_ADD(name) seam::tools::add_##name(app);
          SEAM_COMMANDS(SEAM_ADD)
#undef SEAM_ADD
        });
  });
}
