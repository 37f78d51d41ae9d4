// `seam discover`: adds effects until nothing more is supported by the data.
#include "app/predictors/instruments.h"
#include "measurement/kinds/kinds.h"
#include "measurement/report/report.h"
#include "measurement/report/target_told.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {

void add_discover(app::Command app) {
  app::Command command = app.add_subcommand(
      "discover", "Adds effects until the model is adequate or nothing known helps");
  auto flags = std::make_shared<AnalysisFlags>();
  auto out = std::make_shared<std::string>();
  auto candidates = std::make_shared<std::string>();
  add_analysis_flags(command, *flags, true);
  add_material_flag(command, *flags);
  add_target_out_flag(command, *flags);
  command.add_option("--out", *out, "The model found").required();
  command.add_option("--candidates", *candidates,
                     "A file with effects of your own, tried beside the catalogue");
  command.footer(
      "Example: seam discover --model nominal.yaml --data sets/points-a --out found.yaml");
  command.callback([flags, out, candidates] {
    AnalysisOutputs outputs(*flags, *out);
    const effects::Model model = read_model(flags->model);
    const auto own = candidates->empty() ? measurement::EffectList{} : effects_named(*candidates);
    const auto problem = open_problem(*flags);
    const auto result =
        measurement::search(*problem, model, own, progress_to_terminal(), flags->material);
    outputs.out.fill(measurement::discovered_model(*problem, model, result).to_yaml());
    if (outputs.target)
      outputs.target.fill(measurement::target_table(*problem, result.best.assessment.model));
    const auto doubts = doubts_about(*flags, model, unexplained_error(result));
    outputs.print(
        measurement::discover_text(*problem, result, doubts) + how_to_add(*flags, *out, "", result),
        [&] { return measurement::discover_json(*problem, result, doubts); });
    if (outputs.report) {
      measurement::write_report(
          outputs.report, measurement::discover_report(*problem, result,
                                                       report_header("discover", *flags, doubts)));
    }
  });
}

}  // namespace seam::tools
