// `seam sweep bundle`: a study in one archive, to be repeated by its readers.
#include <cstdio>

#include "app/bundle/bundle.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "tools/sweep/sweep.h"

namespace seam::tools {
namespace {

struct SweepBundleOptions {
  std::string file, out;
  std::vector<std::string> with;
  bool logs = true;
};

void bundle(const SweepBundleOptions& options) {
  const app::BundleManifest made = app::make_bundle(
      {.source = options.file, .out = options.out, .with = options.with, .logs = options.logs});
  uint64_t bytes = 0;
  for (const app::BundleFile& file : made.files) bytes += file.bytes;
  std::printf("%s: %zu files, %.1f MB before compression\n", options.out.c_str(), made.files.size(),
              static_cast<double>(bytes) / 1e6);
  for (const app::BundleFile& file : made.files)
    if (file.name.starts_with("work/")) std::printf("  %s\n", shown(file.name).c_str());
  if (!made.needs.empty()) std::printf("not in it, and needed to run it elsewhere:\n");
  for (const std::string& need : made.needs) std::printf("  %s\n", shown(need).c_str());
  std::printf("try it: seam sweep rerun %s --run-programs\n", options.out.c_str());
}

}  // namespace

void add_sweep_bundle(app::Command sweep) {
  app::Command command = sweep.add_subcommand(
      "bundle", "Packs a study into one archive that `seam sweep rerun` repeats elsewhere");
  auto options = std::make_shared<SweepBundleOptions>();
  command.add_option("FILE", options->file, "Results that `seam sweep` made, or the log of a run")
      .required();
  command.add_option("--out", options->out, "The archive, NAME.seam").required();
  command.add_option("--with", options->with,
                     "Files and folders below the working folder that behaviours\n"
                     "open by themselves");
  command.add_flag("--logs,!--no-logs", options->logs,
                   "Take the logs of a sweep that keeps them (the default): they name\n"
                   "the step at which a run first differs");
  command.footer(
      "Run it in the folder in which the runs were made. The archive has plan, scenario, models,\n"
      "meshes and textures, the behaviours' programs with the files that their commands name and\n"
      "the Python modules beside them, SHA-256 of each, and each run's values and fingerprint.\n"
      "Prints what a behaviour needs beside the bundle (docs/reference/bundle.md).\n"
      "Example: seam sweep bundle results.sqlite --out study.seam");
  command.callback([options] { bundle(*options); });
}

}  // namespace seam::tools
