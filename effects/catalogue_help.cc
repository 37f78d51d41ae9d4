#include "effects/catalogue_help.h"

#include <cmath>

#include "effects/registry.h"
#include "sim_core/base/error.h"

namespace seam::effects {
namespace {

std::string bound_text(double value) {
  if (std::isfinite(value)) return fmt::format("{:.4g}", value);
  return value > 0 ? "infinite" : "-infinite";
}

std::string range_text(const Parameter& parameter) {
  std::string text =
      parameter.required ? "must be given" : "neutral " + bound_text(parameter.neutral);
  return text +
         fmt::format(", from {} to {}", bound_text(parameter.min), bound_text(parameter.max));
}

const Stage kStages[] = {Stage::timing,   Stage::joint,      Stage::mount,
                         Stage::geometry, Stage::radiometry, Stage::light,
                         Stage::sensor,   Stage::detector,   Stage::locomotion};

}  // namespace

std::string kinds_text(unsigned kinds) {
  std::string text;
  for (const KindFacts& kind : seam::effects::kinds()) {
    if (kinds & kind.bit) text += (text.empty() ? "" : ", ") + std::string(kind.name);
  }
  return text;
}

std::string effect_help(const EffectDefinition& effect) {
  std::string text =
      fmt::format("{} (stage {})\n\n{}\n\nFormula:    {}\nSignature:  {}\nActs on:    {}\n",
                  effect.name, to_string(effect.stage), effect.help, effect.formula,
                  effect.signature, kinds_text(effect.kinds));
  if (effect.spread_only) text += "Changes the spread of measurements, not their mean.\n";
  text += effect.parameters.empty() ? "Parameters: none\n" : "Parameters:\n";
  for (const Parameter& parameter : effect.parameters) {
    text += fmt::format("  {}  {} ({})\n", parameter.name, parameter.help, range_text(parameter));
  }
  return text + fmt::format("\nIn a model:\n  effects:\n    {}\n", effect.example);
}

std::string catalogue_list() {
  std::string text;
  for (const Stage stage : kStages) {
    std::string lines;
    for (const auto& effect : catalogue()) {
      if (effect->stage == stage)
        lines += fmt::format("  {:<24} {}\n", effect->name, effect->formula);
    }
    if (!lines.empty()) text += to_string(stage) + "\n" + lines;
  }
  return text + "\n`seam effects NAME` tells more about one.\n";
}

std::string catalogue_markdown() {
  std::string text =
      "# Effects\n\nMade by `seam effects --markdown`; a test compares this page with the "
      "program.\n"
      "Parameters that are left out have their neutral value, at which the effect is absent.\n";
  for (const Stage stage : kStages) {
    text += "\n## Stage `" + to_string(stage) + "`\n";
    for (const auto& effect : catalogue()) {
      if (effect->stage != stage) continue;
      text += fmt::format(
          "\n### `{}`\n\n{}\n\n- Formula: {}\n- Signature in residuals: {}\n- Acts on: {}\n",
          effect->name, effect->help, effect->formula, effect->signature,
          kinds_text(effect->kinds));
      for (const Parameter& parameter : effect->parameters) {
        text +=
            fmt::format("- `{}`: {} ({})\n", parameter.name, parameter.help, range_text(parameter));
      }
      text += fmt::format("\n```yaml\n{}\n```\n", effect->example);
    }
  }
  return text;
}

}  // namespace seam::effects
