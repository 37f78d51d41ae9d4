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

std::string text_of(const std::optional<measurement::Suggestion>& suggestion,
                    const measurement::SearchResult& result, const std::string& file) {
  std::string text;
  if (const auto noises = measurement::noises_found(result); !noises.empty())
    text = fmt::format("noise of the catalogue, before any formula: {}\n", fmt::join(noises, ", "));
  if (!suggestion)
    return text + "no effect is suggested: held-out groups support none beyond the catalogue\n";
  text += fmt::format("suggested effect, in {}:\n", file);
  for (const std::string& term : suggestion->terms) text += "  " + term + "\n";
  text += fmt::format("  error {:.4f} -> {:.4f} on held-out groups", suggestion->error_before,
                      suggestion->error);
  if (!suggestion->beside.empty())
    text += fmt::format(", beside {}: add these first", fmt::join(suggestion->beside, ", "));
  return text + "\n";
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
                     "Writes an effect proposed from the residuals, for seam add; no file where "
                     "none is supported");
  command.footer("Example: seam diagnose --model nominal.yaml --data sets/points-a");
  command.callback([flags, candidates, suggested] {
    AnalysisOutputs outputs(*flags, *suggested);
    const effects::Model model = read_model(flags->model);
    const auto own = candidates->empty() ? measurement::EffectList{} : effects_named(*candidates);
    const auto problem = open_problem(*flags);
    const auto result =
        measurement::search(*problem, model, own, progress_to_terminal(), flags->material);
    std::optional<measurement::Suggestion> suggestion;
    const auto doubts = doubts_about(*flags, model, unexplained_error(result));
    std::string text = measurement::diagnose_text(*problem, result, doubts);
    if (!suggested->empty()) {
      suggestion = measurement::suggest(*problem, result, progress_to_terminal());
      text += text_of(suggestion, result, *suggested);
      if (suggestion) outputs.out.fill(suggestion->yaml);
    }
    outputs.print(text,
                  [&] { return measurement::diagnose_json(*problem, result, suggestion, doubts); });
    if (outputs.report) {
      measurement::write_report(
          outputs.report, measurement::diagnose_report(*problem, result, suggestion,
                                                       report_header("diagnose", *flags, doubts)));
    }
  });
}

}  // namespace seam::tools
