// `seam diagnose`: which effect is missing from a model.
#include <fmt/ranges.h>

#include "app/predictors/instruments.h"
#include "measurement/kinds/kinds.h"
#include "measurement/report/report.h"
#include "measurement/search/order.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

// What was written, or why nothing was.
std::string text_of(const measurement::SearchResult& result, const std::string& file) {
  if (result.suggestion)
    return fmt::format("the formula is written to {}, as the effect '{}'\n", file,
                       result.suggestion->effect);
  std::string text;
  if (const auto noises = measurement::noises_found(result); !noises.empty())
    text = fmt::format("noise of the catalogue, before any formula: {}\n", fmt::join(noises, ", "));
  return text + "no effect is suggested: held-out groups support none beyond the catalogue\n";
}

}  // namespace

void add_diagnose(app::Command app) {
  app::Command command = app.add_subcommand(
      "diagnose", "Names the effect that a model lacks, or says that none is missing");
  auto flags = std::make_shared<AnalysisFlags>();
  auto candidates = std::make_shared<std::string>();
  add_analysis_flags(command, *flags, true);
  add_material_flag(command, *flags);
  command.add_option("--candidates", *candidates,
                     "A file with effects of your own, tried beside the catalogue");
  auto suggested = std::make_shared<std::string>();
  command.add_option("--suggest", *suggested,
                     "Writes the formula that explains what no known effect does, for seam add; no "
                     "file where there is none");
  command.footer("Example: seam diagnose --model nominal.yaml --data sets/points-a");
  command.callback([flags, candidates, suggested] {
    AnalysisOutputs outputs(*flags, *suggested, {*candidates});
    const effects::Model model = read_model(flags->model);
    const auto own = candidates->empty() ? measurement::EffectList{} : effects_named(*candidates);
    const auto problem = open_problem(*flags);
    const auto result =
        measurement::search(*problem, model, own, progress_to_terminal(), flags->material);
    const auto doubts = doubts_about(*flags, model, unexplained_error(result));
    std::string text = measurement::diagnose_text(*problem, result, doubts);
    if (!suggested->empty()) {
      text += text_of(result, *suggested);
      if (result.suggestion) outputs.out.fill(result.suggestion->yaml);
    }
    text += how_to_add(*flags, flags->model, *suggested, result);
    outputs.print(text, [&] { return measurement::diagnose_json(*problem, result, doubts); });
    if (outputs.report) {
      measurement::write_report(
          outputs.report, measurement::diagnose_report(*problem, result,
                                                       report_header("diagnose", *flags, doubts)));
    }
  });
}

}  // namespace seam::tools
