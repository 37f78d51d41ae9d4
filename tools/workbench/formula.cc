#include "tools/workbench/formula.h"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "effects/formulas/formula_stages.h"
#include "effects/kind.h"
#include "effects/model.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::tools {
namespace {

using nlohmann::json;

constexpr size_t kMostFormula = 20'000;
constexpr int kLinesBefore = 3;  // Of a file of effects, before the text.

struct Meaning {
  const char *name, *unit, *meaning;
};
constexpr Meaning kMeanings[] = {
    {"x", "", "right, over the distance, undistorted"},
    {"y", "", "down, over the distance, undistorted"},
    {"r2", "", "x^2 + y^2"},
    {"u", "px", "column in the image"},
    {"v", "px", "row in the image"},
    {"cx", "px", "column of the image's centre"},
    {"cy", "px", "row of the image's centre"},
    {"fx", "px", "focal length along columns"},
    {"fy", "px", "focal length along rows"},
    {"t", "s", "time since the set's reference"},
    {"row", "px", "row at which a point is read out"},
    {"q", "rad", "angle of the joint"},
    {"rate", "rad/s", "its rate"},
    {"command", "rad", "what was commanded"},
    {"rho", "", "distance from the centre, 1 in the corner"},
    {"drive", "rad/s²", "what the motor gives at rest for the controller's duty"},
    {"mean", "DN", "mean value of the pixel"},
    {"range", "m", "distance"},
    {"bearing", "rad", "direction"},
    {"vx", "m/s", "velocity ahead"},
    {"vy", "m/s", "velocity to the left"},
    {"omega", "rad/s", "turn to the left"},
    {"theta", "rad", "heading"},
};

// What a stage is of.
struct StageHelp {
  const char *stage, *help;
};
constexpr StageHelp kStageHelps[] = {
    {"joint", "The angle of each joint, before it moves camera or robot, or what turns its motor."},
    {"target", "Where the target's points lie on it."},
    {"geometry", "Where the lens puts a point in the image."},
    {"corner_detector", "Where a corner is found, beside where the lens puts it."},
    {"radiometry", "How bright the lens makes each place of the image."},
    {"light", "How the light that falls in differs from what was stated."},
    {"sensor", "The value of a pixel, after its noise."},
    {"detector", "What a detector of landmarks measures."},
    {"locomotion", "How the robot moves for a command."},
};

std::string help_of(const std::string& stage) {
  const auto found =
      std::ranges::find_if(kStageHelps, [&](const StageHelp& one) { return stage == one.stage; });
  return found == std::end(kStageHelps) ? "" : found->help;
}

json variable_json(const std::string& name) {
  const auto found =
      std::ranges::find_if(kMeanings, [&](const Meaning& one) { return name == one.name; });
  if (found == std::end(kMeanings)) return {{"name", name}};
  return {{"name", name}, {"unit", found->unit}, {"meaning", found->meaning}};
}

// A beginning to edit: it changes nothing while k is 0.
std::string form_of(const effects::FormulaStage& stage) {
  const std::string& output = stage.outputs.front();
  const std::string& by = stage.variables.front();
  const std::string begins = effects::formula_without_change(output),
                    part = output == "gain" ? "k * rho^2" : "k * " + by,
                    formula = begins == "0" ? part : begins + " + " + part;
  const int reach = begins == "0" ? 1000 : 1;  // A torque is in rad/s^2.
  return fmt::format("{}: \"{}\"\nparameters:\n  k: {{neutral: 0, min: -{}, max: {}}}\n", output,
                     formula, reach, reach);
}

}  // namespace

json formula_stages_json(const std::string& kind) {
  json acting = json::array(), others = json::array();
  for (const effects::FormulaStage& stage : effects::formula_stages()) {
    json variables = json::array();
    for (const std::string& name : stage.variables) variables.push_back(variable_json(name));
    const bool acts = std::ranges::any_of(effects::kinds(), [&](const effects::KindFacts& one) {
      return kind == one.name && (stage.kinds & one.bit) != 0;
    });
    (acts ? acting : others)
        .push_back({{"name", stage.name},
                    {"help", help_of(stage.name)},
                    {"form", form_of(stage)},
                    {"variables", std::move(variables)},
                    {"targets", stage.outputs},
                    {"acts", acts}});
  }
  acting.insert(acting.end(), others.begin(), others.end());
  return {{"stages", std::move(acting)}};
}

std::string formula_file(const std::string& stage, const std::string& name,
                         const std::string& text) {
  const bool plain =
      !name.empty() && name.size() <= 60 &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos &&
      std::isalpha(static_cast<unsigned char>(name.front())) != 0;
  if (!plain)
    throw UsageError("name: expected a letter, then letters, digits and _, all in small letters");
  if (text.size() > kMostFormula) throw UsageError("text: is too long");
  const bool known = std::ranges::any_of(effects::formula_stages(),
                                         [&](const auto& one) { return one.name == stage; });
  if (!known) throw UsageError("stage: expected one of those that have variables");
  std::string file = fmt::format("effects:\n  {}:\n    stage: {}\n", name, stage);
  for (size_t at = 0; at < text.size();) {
    const size_t end = std::min(text.find('\n', at), text.size());
    file += "    " + text.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return file;
}

json with_formula_text(json suggestion) {
  const std::string yaml = suggestion.value("yaml", "");
  const std::string key = "    stage: ";
  const size_t stage = yaml.find("\n" + key);
  if (stage == std::string::npos) return suggestion;
  const size_t first = stage + 1 + key.size(), last = yaml.find('\n', first);
  suggestion["stage"] = yaml.substr(first, last - first);
  std::string text;
  for (size_t at = last; at != std::string::npos && at + 1 < yaml.size();) {
    const size_t end = yaml.find('\n', at + 1);
    const std::string line = yaml.substr(at + 1, end == std::string::npos ? end : end - at - 1);
    text += line.substr(std::min<size_t>(4, line.size())) + "\n";
    at = end;
  }
  suggestion["text"] = text;
  return suggestion;
}

json formula_checked(const std::string& stage, const std::string& name, const std::string& text) {
  const std::string file = formula_file(stage, name, text);
  try {
    const ConfigNode root = ConfigNode::from_text(file, "formula");
    const auto effect = effects::expression_effect(name, root.at("effects").at(name));
    json parameters = json::array();
    for (const effects::Parameter& parameter : effect->parameters)
      parameters.push_back(parameter.name);
    return {{"ok", true}, {"parameters", std::move(parameters)}};
  } catch (const InputError& error) {
    std::string sentence = error.what();
    json fields = {{"ok", false}};
    int line = 0;
    if (sentence.starts_with("formula:")) {
      const auto [end, failed] =
          std::from_chars(sentence.data() + 8, sentence.data() + sentence.size(), line);
      if (failed == std::errc() && line > kLinesBefore) fields["line"] = line - kLinesBefore;
      sentence.erase(0, std::min(sentence.size(),
                                 static_cast<size_t>(end - sentence.data()) + (line > 0 ? 1 : 0)));
      while (sentence.starts_with(' ') || sentence.starts_with(':')) sentence.erase(0, 1);
    }
    fields["error"] = sentence;
    return fields;
  }
}

}  // namespace seam::tools
