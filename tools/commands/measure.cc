// `seam measure`: makes the measurement set that a model would give.
#include <filesystem>
#include <system_error>

#include "app/predictors/instruments.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

// The folder of a set, which goes again where the set is not made.
class FolderOfSet {
 public:
  explicit FolderOfSet(fs::path folder) : folder_(std::move(folder)) {
    std::error_code unknown;
    was_there_ = fs::exists(folder_, unknown);
    make_output_folder(folder_);
  }
  ~FolderOfSet() {
    std::error_code unknown;
    if (!is_made_ && !was_there_) fs::remove_all(folder_, unknown);
  }
  FolderOfSet(const FolderOfSet&) = delete;
  FolderOfSet& operator=(const FolderOfSet&) = delete;
  void is_made() { is_made_ = true; }

 private:
  fs::path folder_;
  bool was_there_ = true, is_made_ = false;
};

}  // namespace

void add_measure(app::Command app) {
  app::Command command =
      app.add_subcommand("measure", "Makes a measurement set with the simulator, by a protocol");
  struct Flags {
    std::string model, protocol, out, noise = "on";
    uint64_t seed = 0;
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
  add_run_flags(command, flags->runs);
  command.footer(
      "Example: seam measure --model truth.yaml --protocol sets/points-a --seed 1 --out made");
  command.callback([flags] {
    const effects::Model truth = read_model(flags->model);
    const auto protocol = measurement::MeasurementSet::open(flags->protocol);
    FolderOfSet folder(flags->out);
    measurement::measure_set(
        truth, protocol, {.seed = flags->seed, .noise = flags->noise == "on", .out = flags->out},
        app::instruments(flags->runs));
    folder.is_made();
    std::printf("%s\n", flags->out.c_str());
  });
}

}  // namespace seam::tools
