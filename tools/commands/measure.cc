// `seam measure`: makes the measurement set that a model would give.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "app/predictors/instruments.h"
#include "app/scratch_folder.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

// The folder of a set. The set is made beside it and moved there once it is whole, file by file, so
// that whatever else is in the folder stays.
class FolderOfSet {
 public:
  FolderOfSet(const fs::path& folder, const fs::path& protocol, bool overwrite)
      : folder_(folder), made_(app::ScratchFolder::beside(folder)) {
    std::error_code unknown;
    if (fs::equivalent(folder_, protocol, unknown))
      throw InputError(fmt::format("{}: the protocol itself, expected another folder to write to",
                                   folder_.string()));
    if (fs::exists(folder_, unknown)) make_output_folder(folder_);  // Says why it cannot be.
    if (!overwrite && fs::exists(folder_ / "measurement.yaml", unknown))
      throw InputError(fmt::format(
          "{}: holds a measurement set already; give another --out, or --force to overwrite it",
          folder_.string()));
  }
  const fs::path& made() const { return made_.path(); }
  void finish() const {
    make_output_folder(folder_);
    for (const auto& entry : fs::recursive_directory_iterator(made())) {
      if (!entry.is_regular_file()) continue;
      const fs::path name = entry.path().lexically_relative(made());
      fs::rename(entry.path(), measurement::written_path(folder_, name.string()));
    }
  }

 private:
  fs::path folder_;
  app::ScratchFolder made_;
};

// A plan with exact values shows any effect: a protocol that states no noise is easily overlooked.
void warn_of_no_noise(const effects::Model& truth, const measurement::MeasurementSet& protocol) {
  const auto& effects = truth.effects();
  const bool spreads = std::any_of(effects.begin(), effects.end(), [](const auto& e) {
    return e.definition->spread_only || e.definition->noise;
  });
  // Numbers of whole runs scatter by the runs themselves.
  if (spreads || !protocol.noise.empty() || protocol.kind == "outcomes") return;
  std::fprintf(
      stderr,
      "warning: the values are made without noise, since neither the protocol (noise:) nor "
      "the model (an effect of spread) states any\n");
}

}  // namespace

void add_measure(app::Command app) {
  app::Command command =
      app.add_subcommand("measure", "Makes a measurement set with the simulator, by a protocol");
  struct Flags {
    std::string model, protocol, out, noise = "on";
    uint64_t seed = 0;
    bool force = false;
    app::OutcomeRunsOptions runs;
  };
  auto flags = std::make_shared<Flags>();
  command.add_option("--model", flags->model, "The true model").required();
  command
      .add_option("--protocol", flags->protocol,
                  "A measurement set; its measured columns are made anew")
      .required();
  command.add_option("--seed", flags->seed, "Seed of all noise").show_default();
  command.add_option("--out", flags->out, "The folder to write").required();
  command.add_option("--noise", flags->noise, "on or off").one_of({"on", "off"}).show_default();
  command.add_flag("--force", flags->force, "Overwrites a set that is there");
  add_run_flags(command, flags->runs);
  command.footer(
      "Example: seam measure --model truth.yaml --protocol sets/points-a --seed 1 --out made");
  command.callback([flags] {
    const effects::Model truth = read_model(flags->model);
    const auto protocol = measurement::MeasurementSet::open(flags->protocol);
    const FolderOfSet folder(flags->out, flags->protocol, flags->force);
    std::vector<std::string> warnings;
    measurement::measure_set(truth, protocol,
                             {.seed = flags->seed,
                              .noise = flags->noise == "on",
                              .out = folder.made(),
                              .warnings = &warnings},
                             app::instruments(flags->runs));
    folder.finish();
    for (const std::string& warning : warnings)
      std::fprintf(stderr, "warning: %s\n", warning.c_str());
    if (flags->noise == "on") warn_of_no_noise(truth, protocol);
    std::printf("%s\n", flags->out.c_str());
  });
}

}  // namespace seam::tools
