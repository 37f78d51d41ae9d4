// `seam add`: fits one effect and adds it to a model.
#include <fmt/ranges.h>

#include <algorithm>

#include "effects/catalogue_help.h"
#include "effects/registry.h"
#include "measurement/report/figures_told.h"
#include "measurement/report/target_told.h"
#include "measurement/report/told.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

// One line a reason: what many parameters share is said once.
std::string not_fitted_text(const std::vector<measurement::NotTestable>& all) {
  constexpr size_t kMostNamed = 4;
  std::vector<std::pair<std::string, std::vector<std::string>>> names;  // By reason.
  for (const measurement::NotTestable& n : all) {
    auto found = std::find_if(names.begin(), names.end(),
                              [&](const auto& entry) { return entry.first == n.why; });
    if (found == names.end()) found = names.insert(names.end(), {n.why, {}});
    found->second.push_back(n.parameter.empty() ? n.effect : n.effect + "." + n.parameter);
  }
  std::string text;
  for (auto& [why, list] : names) {
    const size_t more = list.size() > kMostNamed ? list.size() - kMostNamed : 0;
    list.resize(list.size() - more);
    text += fmt::format("  not fitted: {}{}: {}\n", fmt::join(list, ", "),
                        more == 0 ? "" : fmt::format(" and {} more", more), why);
  }
  return text;
}

// `before`: the model to which the effect was added.
std::string text_of(const measurement::AddResult& result, const effects::Model& before) {
  std::string text = result.effect.empty() ? "refitted\n"
                     : before.has(result.effect)
                         ? "refitted " + result.effect + ", which the model has already\n"
                         : "added " + result.effect + "\n";
  for (const std::string& name : result.replaced) text += fmt::format("  instead of {}\n", name);
  const effects::ModelEffect* added = result.model.find(result.effect);
  const size_t count = result.parameters.size();
  const size_t shown = added != nullptr && effects::has_many_values(*added->definition) ? 1 : count;
  for (size_t i = 0; i < shown; ++i) {
    const auto& [name, value] = result.parameters[i];
    text += fmt::format("  {} = {}\n", name, measurement::told_value(result.model, name, value));
  }
  if (shown < count) text += fmt::format("  and {} more values, in the model\n", count - shown);
  text += not_fitted_text(result.not_testable);
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
    AnalysisOutputs outputs(*flags, *out, {effects::find_effect(*effect) ? "" : *effect});
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
