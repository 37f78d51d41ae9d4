// `seam add`: fits one effect and adds it to a model.
#include "measurement/report/figures_told.h"
#include "measurement/report/target_told.h"
#include "measurement/report/told.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

// `before`: the model to which the effect was added.
std::string text_of(const measurement::AddResult& result, const effects::Model& before) {
  std::string text = result.effect.empty() ? "refitted\n"
                     : before.has(result.effect)
                         ? "refitted " + result.effect + ", which the model has already\n"
                         : "added " + result.effect + "\n";
  for (const std::string& name : result.replaced) text += fmt::format("  instead of {}\n", name);
  for (const auto& [name, value] : result.parameters)
    text += fmt::format("  {} = {}\n", name, measurement::told_value(result.model, name, value));
  for (const measurement::NotTestable& n : result.not_testable)
    text += fmt::format("  not fitted: {}{}{}: {}\n", n.effect, n.parameter.empty() ? "" : ".",
                        n.parameter, n.why);
  return text + fmt::format("error on held-out groups {:.4f} -> {:.4f} (1.0 is the noise)\n",
                            result.error_before, result.error_after);
}

void print_added(AnalysisOutputs& outputs, const AnalysisFlags& flags,
                 const measurement::Problem& problem, const effects::Model& before,
                 const measurement::AddResult& result, const std::string& format) {
  const auto doubts = doubts_about(flags, result.model, result.error_after);
  outputs.print(measurement::doubts_text(doubts) + text_of(result, before) +
                    measurement::target_text(problem, result.model) +
                    measurement::figures_text(problem, result.assessment),
                [&] { return measurement::add_json(problem, result, format, doubts); });
}

}  // namespace

void add_add(app::Command app) {
  app::Command command =
      app.add_subcommand("add", "Fits an effect to measurements and adds it to a model");
  auto flags = std::make_shared<AnalysisFlags>();
  auto effect = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command.add_option("EFFECT", *effect, "A name of the catalogue, or a file with effects")
      .required();
  add_analysis_flags(command, *flags, false);
  add_target_out_flag(command, *flags);
  command.add_option("--out", *out, "The model with the effect").required();
  command.footer(
      "Example: seam add rolling_shutter --model nominal.yaml --data sets/points-a --out "
      "better.yaml");
  command.callback([flags, effect, out] {
    AnalysisOutputs outputs(*flags, *out);
    const effects::Model model = read_model(flags->model);
    const auto effects = effects_named(*effect);
    const auto problem = open_problem(*flags);
    const auto result = measurement::add_effects(*problem, model, effects);
    outputs.out.fill(result.model.to_yaml());
    if (outputs.target) outputs.target.fill(measurement::target_table(*problem, result.model));
    print_added(outputs, *flags, *problem, model, result, "seam-add/1");
  });
}

void add_fit(app::Command app) {
  app::Command command = app.add_subcommand("fit", "Refits the parameters that a model has");
  auto flags = std::make_shared<AnalysisFlags>();
  auto out = std::make_shared<std::string>();
  add_analysis_flags(command, *flags, false);
  add_target_out_flag(command, *flags);
  command.add_option("--out", *out, "The refitted model").required();
  command.footer("Example: seam fit --model better.yaml --data sets/points-a --out refitted.yaml");
  command.callback([flags, out] {
    AnalysisOutputs outputs(*flags, *out);
    const effects::Model model = read_model(flags->model);
    const auto problem = open_problem(*flags);
    const auto result = measurement::refit_all(*problem, model);
    outputs.out.fill(result.model.to_yaml());
    if (outputs.target) outputs.target.fill(measurement::target_table(*problem, result.model));
    print_added(outputs, *flags, *problem, model, result, "seam-fit/1");
  });
}

}  // namespace seam::tools
