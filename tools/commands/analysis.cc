#include "tools/commands/analysis.h"

#include <fmt/ranges.h>

#include <fstream>
#include <set>

#include "app/data_file.h"
#include "app/import/recognise.h"
#include "app/predictors/instruments.h"
#include "effects/effect_keys.h"
#include "effects/registry.h"
#include "measurement/check/doubts.h"
#include "measurement/judge/decisions.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::tools {

void add_analysis_flags(app::Command command, AnalysisFlags& flags, bool with_report) {
  command.add_option("--model", flags.model, "The model (seam-model/1)").required();
  add_data_flags(command, flags, with_report);
}

void add_data_flags(app::Command command, AnalysisFlags& flags, bool with_report) {
  command.add_option("--data", flags.data, "The folder of the measurement set").required();
  command.add_option("--leave-out", flags.leave_out,
                     "A table row,reason of rows that take no part: their lines in the file of "
                     "observations (a column `file` names another table of the set)");
  command.add_option("--target", flags.target,
                     "Of points: a file of where the target's points were found (--target-out)");
  add_run_flags(command, flags.runs);
  command.add_option("--json", flags.json, "Writes the result as JSON");
  if (with_report) command.add_option("--report", flags.report, "Writes the result as a web page");
}

void add_run_flags(app::Command command, app::OutcomeRunsOptions& options) {
  command.add_option("--runs", options.kept,
                     "Of outcomes: a folder where runs are kept, so that the command goes on where "
                     "it was interrupted");
  command.add_flag(
      "--run-programs", options.run_programs,
      "Of outcomes: programs that the set names and that are not SEAM's may be started");
}

void add_target_out_flag(app::Command command, AnalysisFlags& flags) {
  command.add_option("--target-out", flags.target_out,
                     "Of points: writes where the target's points were found, for other sets");
}

std::unique_ptr<measurement::Problem> open_problem(const AnalysisFlags& flags) {
  app::refuse_foreign_file(flags.data);
  auto problem = measurement::open_problem(open_set(flags), app::instruments(flags.runs));
  say_work("fitting the model");
  return problem;
}

measurement::MeasurementSet open_set(const AnalysisFlags& flags) {
  measurement::MeasurementSet set = measurement::open_set(flags.data, flags.leave_out);
  set.target = flags.target;
  return set;
}

effects::Model read_model(const std::string& path) {
  return effects::Model::from_file(app::given_or_ours(path));
}

void add_material_flag(app::Command command, AnalysisFlags& flags) {
  command
      .add_option(
          "--material", flags.material,
          "Noise units by which a structure or an effect must change predictions to matter; "
          "what is only significant is a trace. 0: whatever is significant matters")
      .range(0.0, 1000.0)
      .show_default();
}

measurement::Doubts doubts_about(const AnalysisFlags& flags, const effects::Model& model,
                                 double error) {
  return measurement::doubts(open_set(flags), model, error);
}

double unexplained_error(const measurement::SearchResult& result) {
  const double found = result.best.assessment.error;
  return found < measurement::kMisfit ? found : result.base.assessment.error;
}

namespace {

std::string how_to_add_lens(const AnalysisFlags& flags, const std::string& model,
                            const measurement::SearchResult& result) {
  if (!result.splines) return "";
  std::vector<std::string> first;
  for (const std::string& name : result.splines->beside) {
    const bool found = model != flags.model && result.best.assessment.model.has(name);
    if (!found) first.push_back(name);
  }
  return fmt::format("to keep the lens of splines: {}seam add {} --model {} --data {} --out {}\n",
                     first.empty() ? "" : fmt::format("add {}, then ", fmt::join(first, ", ")),
                     result.splines->effect, model, flags.data, "with_splines.yaml");
}

std::string how_to_add_formula(const AnalysisFlags& flags, const std::string& model,
                               const std::string& suggested,
                               const measurement::SearchResult& result) {
  if (!result.suggestion || result.suggestion->error > measurement::kMisfit) return "";
  const std::string file = suggested.empty() ? "NAME.yaml" : suggested;
  std::string text = "to keep the formula: ";
  if (suggested.empty())
    text += fmt::format("seam diagnose --model {} --data {} --suggest {}, then ", flags.model,
                        flags.data, file);
  text += fmt::format("write a name for '{}' in {}, then ", result.suggestion->effect, file);
  // The formula holds beside effects that the model lacks: a search adds them all.
  if (model == flags.model && !result.suggestion->beside.empty())
    return text +
           fmt::format("seam discover --model {} --data {} --candidates {} --out with_NAME.yaml\n",
                       model, flags.data, file);
  return text + fmt::format("seam add {} --model {} --data {} --out with_NAME.yaml\n", file, model,
                            flags.data);
}

}  // namespace

std::string how_to_add(const AnalysisFlags& flags, const std::string& model,
                       const std::string& suggested, const measurement::SearchResult& result) {
  return how_to_add_formula(flags, model, suggested, result) +
         how_to_add_lens(flags, model, result);
}

namespace {

// Those in `folder` that a key anywhere below `node` names: tables, poses, a scene, a scenario.
void add_named_files(const ConfigNode& node, const std::filesystem::path& folder,
                     std::vector<std::filesystem::path>& files) {
  if (node.is_map()) {
    for (const std::string& key : node.keys()) add_named_files(node.at(key), folder, files);
  } else if (node.is_scalar()) {
    std::error_code is_none;
    const std::filesystem::path path = folder / node.text();
    if (is_regular_file(path, is_none)) files.push_back(path);
  } else if (!node.is_null()) {
    for (const ConfigNode& item : node.items()) add_named_files(item, folder, files);
  }
}

// Its header says so: tables of a hundred thousand rows are not read for this.
bool names_pictures(const std::filesystem::path& table) {
  std::error_code is_none;
  if (!is_regular_file(table, is_none)) return false;
  std::ifstream in(table);
  std::string header;
  std::getline(in, header);
  return measurement::CsvTable::from_text(header + "\n", table.filename().string()).has("file");
}

}  // namespace

std::vector<std::filesystem::path> files_of_set(const std::string& folder) {
  std::vector<std::filesystem::path> files = {std::filesystem::path(folder) / "measurement.yaml"};
  try {
    const auto set = measurement::MeasurementSet::open(folder);
    add_named_files(set.root, set.folder, files);
    for (const auto& [name, file] : set.files) {
      if (!std::string_view(file).ends_with(".csv") || !names_pictures(set.folder / file)) continue;
      for (const std::string& picture : set.table(name).texts("file"))
        files.push_back(set.folder / picture);
    }
  } catch (const std::exception&) {
  }
  return files;
}

namespace {

// Of two outputs in one file one would be lost. Devices and pipes take both.
void refuse_one_file_twice(const std::vector<std::string>& outputs) {
  std::set<std::filesystem::path> paths;
  for (const std::string& output : outputs) {
    std::error_code error;
    const auto path = std::filesystem::weakly_canonical(output, error);
    if (output.empty() || error || (exists(path) && !is_regular_file(path))) continue;
    if (!paths.insert(path).second)
      throw UsageError(
          fmt::format("{}: two outputs have this name; give each one of its own", output));
  }
}

}  // namespace

AnalysisOutputs::AnalysisOutputs(const AnalysisFlags& flags, const std::string& out_file,
                                 const std::vector<std::string>& further) {
  OutputRules rules{.inputs = files_of_set(flags.data)};
  rules.inputs.insert(rules.inputs.end(), {flags.model, flags.leave_out, flags.target});
  rules.inputs.insert(rules.inputs.end(), further.begin(), further.end());
  refuse_one_file_twice(
      {flags.json, flags.report, out_file, flags.target_out, flags.attitudes_out});
  json = OutputFile(flags.json, rules);
  report = OutputFile(flags.report, rules);
  out = OutputFile(out_file, rules);
  target = OutputFile(flags.target_out, rules);
  attitudes = OutputFile(flags.attitudes_out, rules);
}

void AnalysisOutputs::print(const std::string& text,
                            const std::function<std::string()>& make_json) {
  progress_.print_between(shown_lines(text));
  say_work("writing results");
  if (json) json.fill(make_json());
}

measurement::ReportHeader report_header(const std::string& command, const AnalysisFlags& flags,
                                        const measurement::Doubts& doubts) {
  const std::string left_out =
      flags.leave_out.empty() ? "" : fmt::format(" --leave-out {}", flags.leave_out);
  return {.command = fmt::format("seam {} --model {} --data {}{} --report {}", command, flags.model,
                                 flags.data, left_out, flags.report),
          .model_file = flags.model,
          .data_folder = flags.data,
          .left_out = open_set(flags).left_out,
          .doubts = doubts};
}

measurement::Progress progress_to_terminal() {
  return [](const std::string& what) { say_work(what); };
}

measurement::EffectList effects_named(const std::string& name_or_file) {
  if (auto effect = effects::find_effect(name_or_file)) return {effect};
  const bool is_file =
      name_or_file.find('.') != std::string::npos || name_or_file.find('/') != std::string::npos;
  if (!is_file)
    throw InputError(fmt::format("unknown effect '{}'{}", name_or_file,
                                 suggestion_for(name_or_file, effects::effect_names())));
  const ConfigNode root = ConfigNode::from_file(name_or_file);
  root.keys();  // None stands twice; a whole model has more of them than `effects`.
  measurement::EffectList list;
  const ConfigNode effects = root.at("effects");
  for (const std::string& name : effects::effect_keys(effects)) {
    const ConfigNode node = effects.at(name);
    if (node.is_map() && node.has("stage")) {
      list.push_back(effects::expression_effect(name, node));
    } else if (auto effect = effects::find_effect(name)) {
      list.push_back(effect);
    } else {
      effects.fail(fmt::format("unknown effect '{}'{}", name,
                               suggestion_for(name, effects::effect_names())));
    }
  }
  if (list.empty()) effects.fail("found no effects, expected one or more");
  return list;
}

}  // namespace seam::tools
