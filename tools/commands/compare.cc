// `seam compare`: residuals of a model on held-out groups, and where they fail.
#include "app/predictors/instruments.h"
#include "measurement/kinds/kinds.h"
#include "measurement/report/report.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {

void add_compare(app::Command app) {
  app::Command command =
      app.add_subcommand("compare", "Holds a model against measurements and says where it fails");
  auto flags = std::make_shared<AnalysisFlags>();
  add_analysis_flags(command, *flags, true);
  add_material_flag(command, *flags);
  command.footer(
      "Example: seam compare --model nominal.yaml --data sets/points-a --json compare.json");
  command.callback([flags] {
    AnalysisOutputs outputs(*flags);
    const effects::Model model = read_model(flags->model);
    const auto problem = measurement::open_problem(flags->data, app::instruments());
    const auto result = measurement::compare(*problem, model, flags->material);
    outputs.tell(with_doubts(measurement::compare_text(*problem, result), *flags, model,
                             result.base.assessment.error),
                 measurement::compare_json(*problem, result));
    if (outputs.report) {
      measurement::write_report(
          outputs.report,
          measurement::compare_report(*problem, result, report_header("compare", *flags)));
    }
  });
}

}  // namespace seam::tools
