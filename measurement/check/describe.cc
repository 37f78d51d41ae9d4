#include "measurement/check/describe.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "effects/registry.h"
#include "effects/stages/lens_domain.h"
#include "measurement/check/doubts.h"
#include "measurement/check/faults.h"
#include "measurement/kinds/kinds.h"
#include "sim_core/base/error.h"

namespace seam::measurement {

std::string unit_of(const std::string& column) {
  static constexpr std::pair<const char*, const char*> kUnits[] = {
      {"_radps", "rad/s"}, {"_mps2", "m/s^2"}, {"_mps", "m/s"}, {"_rad", "rad"}, {"_px", "px"},
      {"_nm", "N m"},      {"_m", "m"},        {"_s", "s"},     {"_v", "V"}};
  for (const auto& [suffix, unit] : kUnits) {
    if (column.ends_with(suffix)) return unit;
  }
  return "";
}
namespace {

std::string column_line(const CsvTable& table, const std::string& column) {
  const std::vector<std::string> texts = table.texts(column);
  const auto blanks = std::count(texts.begin(), texts.end(), "");
  std::string range;
  try {
    std::vector<double> values = table.numbers_or_blank(column);
    std::erase_if(values, [](double value) { return std::isnan(value); });
    if (!values.empty()) {
      const auto [least, most] = std::minmax_element(values.begin(), values.end());
      range = fmt::format("{:.10g} to {:.10g}", *least, *most);
    }
  } catch (const InputError&) {
    const std::set<std::string> different(texts.begin(), texts.end());
    range = fmt::format("{} different", different.size());
  }
  if (blanks > 0) range += fmt::format("{}{} blank", range.empty() ? "" : ", ", blanks);
  return fmt::format("    {:<20} {:<6} {}\n", column, unit_of(column), range);
}

std::string tables_text(const MeasurementSet& set) {
  std::string text;
  for (const auto& [name, file] : set.files) {
    if (!file.ends_with(".csv")) {
      text += fmt::format("  {:<12} {}\n", name, file);
      continue;
    }
    const CsvTable table = set.table(name);
    text += fmt::format("  {:<12} {}, {} rows\n", name, file, table.rows());
    for (const std::string& column : table.columns()) text += column_line(table, column);
  }
  return text;
}

std::string groups_text(const Problem& problem, const std::string& column) {
  const Facts& facts = problem.facts();
  std::map<int, size_t> rows_of_group;
  for (const int group : facts.group_of_row) ++rows_of_group[group];
  size_t least = facts.rows(), most = 0;
  for (const auto& [group, rows] : rows_of_group)
    least = std::min(least, rows), most = std::max(most, rows);
  std::string text = fmt::format("  groups       {} by {}, of {} to {} observations",
                                 facts.groups.size(), column, least, most);
  if (problem.folds().size() == 1) {
    const Groups& held = problem.folds().front();
    text += fmt::format("; {} held out", std::count(held.begin(), held.end(), 1));
  } else {
    text += "; each is held out in turn";
  }
  return text + "\n";
}

std::string noise_text(const Facts& facts) {
  std::string text;
  for (const Channel& channel : facts.channels) {
    text += fmt::format("  noise        {:<16} {:.4g} {}\n", channel.name, channel.noise,
                        channel.estimated    ? "estimated: the set states none"
                        : channel.noise == 0 ? "where the set states none and effects make it"
                                             : "stated");
  }
  return text;
}

Model with(Model model, const std::shared_ptr<const EffectDefinition>& effect,
           const std::vector<double>& values) {
  std::vector<effects::ParameterValue> parameters;
  for (const double value : values) parameters.push_back({.value = value});
  model.set(effect, std::move(parameters));
  return model;
}

// Each effect once: by its first parameter that can be tested, else by the reason of its first.
std::string testable_text(const Problem& problem, const Model& model) {
  std::vector<std::string> testable;
  std::map<std::string, std::vector<std::string>> not_testable;  // By reason.
  for (const auto& effect : effects::catalogue()) {
    if (!problem.acts(*effect) || effect->parameters.empty()) continue;
    const auto starts = problem.starts(model, *effect);
    if (starts.empty()) continue;
    const Model probe = model.has(effect->name) ? model : with(model, effect, starts.front());
    std::string reason;
    bool any = false;
    for (size_t p = 0; p < effect->parameters.size(); ++p) {
      const std::string why = problem.not_testable(probe, *effect, p);
      any = any || why.empty();
      if (reason.empty()) reason = why;
    }
    if (any) {
      testable.push_back(effect->name);
    } else {
      not_testable[reason].push_back(effect->name);
    }
  }
  std::string text =
      fmt::format("  testable     {} effects: {}\n", testable.size(), fmt::join(testable, ", "));
  for (const auto& [reason, names] : not_testable)
    text += fmt::format("  not testable {}: {}\n", fmt::join(names, ", "), reason);
  return text;
}

std::string behind_text(const MeasurementSet& set, const Kind& kind,
                        const std::optional<Model>& model, SetDescription& description) {
  const Model none =
      Model::from_config(ConfigNode::from_text("format: seam-model/1\neffects: {}\n", "none"));
  const std::vector<int> behind = kind.behind_camera(model ? *model : none, set);
  if (!behind.empty()) description.warnings.push_back(behind_the_camera(set, kind, behind));
  return fmt::format("  behind       {} points stand behind the camera ({})\n", behind.size(),
                     model ? "with the model" : "by the rig alone");
}

// Of the model that was named, or of the one that an import left beside the set.
void doubt_lenses(const MeasurementSet& set, const std::optional<Model>& model,
                  SetDescription& description) {
  const auto nominal = set.folder / "nominal.yaml";
  if (set.camera.width_px == 0 || (!model && !std::filesystem::exists(nominal))) return;
  const std::string name = model ? "the model" : "nominal.yaml";
  for (const std::string& doubt :
       effects::lens_doubts(model ? *model : Model::from_file(nominal.string()),
                            set.camera.width_px, set.camera.height_px))
    description.warnings.push_back(fmt::format("{}: {}", name, doubt));
}

}  // namespace

SetDescription describe_set(const MeasurementSet& set, const std::optional<Model>& model,
                            const Instruments& instruments) {
  const Kind& kind = find_kind(set.kind);
  SetDescription description;
  std::string& text = description.text;
  text = fmt::format("measurement set of kind {}: {}\n", set.kind, set.title);
  if (set.camera.width_px > 0)
    text += fmt::format("  camera       {} x {} pixels, {}, {} bits\n", set.camera.width_px,
                        set.camera.height_px, set.camera.channels, set.camera.bits);
  text += tables_text(set);
  const Concerns concerns = concerns_of(set, kind.observations);
  description.errors = concerns.errors;
  description.warnings = concerns.warnings;
  for (const auto& faults : {faults_of_values(set), faults_of_clocks(set)})
    description.warnings.insert(description.warnings.end(), faults.begin(), faults.end());
  text += fmt::format("  rows twice   {} equal, {} measured anew\n", concerns.rows_twice,
                      concerns.measured_anew);
  if (kind.observations.in_image)
    text += fmt::format("  outside      {} points lie outside the image\n", concerns.outside_image);
  try {
    doubt_lenses(set, model, description);
  } catch (const InputError& error) {
    description.errors.emplace_back(error.what());
  }
  try {
    if (kind.behind_camera) text += behind_text(set, kind, model, description);
  } catch (const InputError& error) {
    // What is odd of the tables may say why.
    description.errors.emplace_back(error.what());
    return description;
  }
  if (is_protocol(set, kind.observations)) {
    text += "  a protocol: nothing is measured yet (seam measure)\n";
    return description;
  }
  try {
    const auto problem = kind.open(set, instruments);
    text += groups_text(*problem, set.group) + noise_text(problem->facts());
    for (const std::string& note : problem->facts().notes)
      text += fmt::format("  note         {}\n", note);
    if (model) {
      problem->check_model(*model);
      problem->prepare(*model);
      text += testable_text(*problem, *model);
    }
  } catch (const InputError& error) {
    description.errors.emplace_back(error.what());
  }
  return description;
}

}  // namespace seam::measurement
