// `seam experiment NAME`: the founding paper's experiments, repeated.
#include <functional>

#include "app/sweep/workers.h"
#include "tools/command.h"
#include "tools/experiments/experiments.h"

namespace seam::tools {
namespace {

void add_one(app::Command parent, const std::string& name, const std::string& help,
             const std::function<void(const ExperimentOptions&, OutputFile&)>& experiment) {
  app::Command command = parent.add_subcommand(name, help);
  auto options = std::make_shared<ExperimentOptions>();
  auto json_file = std::make_shared<std::string>();
  options->folder = "out/" + name;
  options->parallel = app::machine_cores();
  command.add_option("--out", options->folder, "Folder for runs, tables and plots").show_default();
  command.add_option("--json", *json_file, "Write the results here as JSON");
  command.add_option("--seeds", options->seeds, "Independent repetitions")
      .range(1, 1000)
      .show_default();
  command.add_option("--poses", options->poses, "Poses of the robot; 0: the usual number")
      .range(0, 36)
      .show_default();
  command.add_option("--seconds", options->duration_s, "Length of each run of a turning head")
      .range(8.0, 3600.0)
      .show_default();
  command.add_option("--jobs", options->parallel, "Runs at a time (default: one for each core)")
      .range(1, 256);
  command.add_flag("--quick", options->quick, "A small form: few poses, one seed");
  command.footer("Example: seam experiment " + name + " --quick");
  command.callback([options, json_file, experiment] {
    OutputFile json(*json_file);
    experiment(*options, json);
  });
}

}  // namespace

void add_experiment(app::Command app) {
  app::Command command =
      app.add_subcommand("experiment", "Repeats the founding paper's experiments");
  command.require_subcommand();
  add_one(command, "ball-distance", "Section 5.1: distance to a ball, mean and deviation",
          ball_distance_experiment);
  add_one(command, "localization", "Section 5.2: localisation at 36 poses, Table 1",
          localization_experiment);
  add_one(command, "head-swing-bias", "What locking frames to the head's swing does",
          head_swing_bias_experiment);
}

}  // namespace seam::tools
