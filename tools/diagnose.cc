// `seam diagnose`: which effect is missing from a model.
#include "measurement/kinds.h"
#include "measurement/report.h"
#include "tools/analysis.h"
#include "tools/command.h"

namespace seam::tools {

void add_diagnose(Command app) {
  Command command = app.add_subcommand("diagnose", "Names the effect that a model lacks, or says that none is missing");
  auto flags = std::make_shared<AnalysisFlags>();
  auto candidates = std::make_shared<std::string>();
  add_analysis_flags(command, *flags, true);
  command.add_option("--candidates", *candidates, "A file with effects of your own, tried beside the catalogue");
  command.footer("Example: seam diagnose --model nominal.yaml --data sets/points-a");
  command.callback([flags, candidates] {
    const effects::Model model = read_model(flags->model);
    const auto own = candidates->empty() ? measurement::EffectList{} : effects_named(*candidates);
    const auto problem = measurement::open_problem(flags->data);
    const auto result = measurement::search(*problem, model, own, progress_to_terminal());
    tell(*flags, measurement::diagnose_text(*problem, result), measurement::diagnose_json(*problem, result));
    if (!flags->report.empty()) {
      measurement::write_report(flags->report, measurement::diagnose_report(*problem, result, report_header("diagnose", *flags)));
    }
  });
}

}  // namespace seam::tools
