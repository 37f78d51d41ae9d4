// The `seam` command.
#include <algorithm>
#include <cstdio>
#include <exception>

#include "sim_core/error.h"
#include "tools/command.h"
#include "tools/frame_predictor.h"
#include "tools/plugins.h"

int main(int argc, char** argv) {
  CLI::App app{"SEAM: simulator of environment and measurement", "seam"};
  app.require_subcommand(1);
  seam::tools::supply_renderer_to_measurements();
  app.set_version_flag("--version", "seam 0.1.0");
#define SEAM_ADD(name) seam::tools::add_##name(app);
  SEAM_COMMANDS(SEAM_ADD)
#undef SEAM_ADD
  try {
    // CLI11 takes the arguments last to first.
    std::vector<std::string> arguments = seam::tools::load_plugins({argv + 1, argv + argc});
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const seam::tools::ExitCode& exit) {
    return exit.code;
  } catch (const seam::UsageError& error) {
    std::fprintf(stderr, "seam: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seam: %s\n", error.what());
    return 1;
  }
  return 0;
}
