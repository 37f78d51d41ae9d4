// `seam history`: how a model came about.
#include "sim_core/error.h"
#include "tools/analysis.h"
#include "tools/command.h"

namespace seam::tools {

void add_history(CLI::App& app) {
  auto* command = app.add_subcommand("history", "Shows the versions of a model and the error falling");
  auto file = std::make_shared<std::string>();
  command->add_option("MODEL", *file, "The model")->required();
  command->footer("Example: seam history found.yaml");
  command->callback([file] {
    const effects::Model model = read_model(*file);
    if (model.history().empty()) std::printf("%s has no history: it was written by hand\n", file->c_str());
    int version = 0;
    for (const effects::HistoryStep& step : model.history()) {
      std::string parameters;
      for (const auto& [name, value] : step.parameters) {
        parameters += fmt::format("{}{} = {:.6g}", parameters.empty() ? "" : ", ", name, value.value);
      }
      std::fputs(fmt::format("{:2d}  {:24s} {:9.4f} -> {:9.4f}   {}   ({}, {})\n", ++version,
                             step.effect.empty() ? "refit" : step.effect, step.error_before, step.error_after, parameters,
                             step.data, step.data_fingerprint).c_str(), stdout);
    }
  });
}

}  // namespace seam::tools
