// `seam history`: how a model came about.
#include "measurement/report/report.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {

void add_history(app::Command app) {
  app::Command command =
      app.add_subcommand("history", "Shows the versions of a model and the error falling");
  auto file = std::make_shared<std::string>();
  auto flags = std::make_shared<AnalysisFlags>();
  command.add_option("MODEL", *file, "The model").required();
  command.add_option("--json", flags->json, "Writes the versions as JSON");
  command.add_option("--report", flags->report, "Writes them as a web page");
  command.footer("Example: seam history found.yaml");
  command.callback([file, flags] {
    OutputFile json(flags->json, {.inputs = {*file}});
    OutputFile report(flags->report, {.inputs = {*file}});
    const effects::Model model = read_model(*file);
    if (model.history().empty())
      std::printf("%s has no history: it was written by hand\n", file->c_str());
    int version = 0;
    for (const effects::HistoryStep& step : model.history()) {
      std::string parameters;
      for (const auto& [name, value] : step.parameters) {
        parameters +=
            fmt::format("{}{} = {:.6g}", parameters.empty() ? "" : ", ", name, value.value);
      }
      std::fputs(fmt::format("{:2d}  {:24s} {:9.4f} -> {:9.4f}   {}   ({}, {})\n", ++version,
                             step.effect.empty() ? "refit" : step.effect, step.error_before,
                             step.error_after, parameters, step.data, step.data_fingerprint)
                     .c_str(),
                 stdout);
    }
    if (json) json.fill(measurement::history_json(model));
    if (report) {
      measurement::write_report(
          report,
          measurement::history_report(
              model, {.command = fmt::format("seam history {} --report {}", *file, flags->report),
                      .model_file = *file,
                      .data_folder = ""}));
    }
  });
}

}  // namespace seam::tools
