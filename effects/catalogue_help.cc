#include "effects/catalogue_help.h"

#include <algorithm>
#include <cmath>

#include "effects/cameras.h"
#include "effects/questions.h"
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
  text += fmt::format(", from {} to {}", bound_text(parameter.min), bound_text(parameter.max));
  const Plausible& plausible = parameter.plausible;
  if (plausible.source.empty()) return text;
  return text + fmt::format("; plausible {} to {}: {}", bound_text(plausible.min),
                            bound_text(plausible.max), plausible.source);
}

// "joints; pan_rad a pan joint": what a set must hold, of all parameters and of single ones.
std::string needs_text(const EffectDefinition& effect) {
  std::vector<std::vector<Need>> needs;
  for (size_t i = 0; i < effect.parameters.size(); ++i) needs.push_back(needs_of(effect, i));
  if (needs.empty()) return "";
  std::vector<std::string> words, parts;
  for (const Need need : needs.front()) {
    const bool all = std::all_of(needs.begin(), needs.end(), [&](const auto& list) {
      return std::find(list.begin(), list.end(), need) != list.end();
    });
    if (all) words.push_back(to_string(need));
  }
  if (!words.empty()) parts.push_back(fmt::format("{}", fmt::join(words, ", ")));
  for (size_t i = 0; i < needs.size(); ++i) {
    std::vector<std::string> own;
    for (const Need need : needs[i]) {
      if (std::find(words.begin(), words.end(), to_string(need)) == words.end())
        own.push_back(to_string(need));
    }
    if (!own.empty())
      parts.push_back(fmt::format("{}: {}", effect.parameters[i].name, fmt::join(own, ", ")));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

// "frame_latency (points): Swing faster ...": one line an advice.
std::vector<std::string> advice_lines(const EffectDefinition& effect) {
  std::vector<std::string> lines;
  for (const Advice& advice : effect.advice) {
    if (of_points_alone(effect) && advice.kinds == kOutcomes) continue;  // not_pictured()
    lines.push_back(fmt::format(
        "{} ({}): {}",
        advice.from.empty() ? "others" : fmt::format("{}", fmt::join(advice.from, ", ")),
        kinds_text(advice.kinds), advice.text));
  }
  return lines;
}

std::string list_text(const std::vector<Quantity>& list) {
  std::string text;
  for (const Quantity& quantity : list)
    text += fmt::format("{}{} {:.10g}", text.empty() ? "" : ", ", quantity.name, quantity.value);
  return text;
}

const Stage kStages[] = {Stage::timing,   Stage::joint,           Stage::mount,      Stage::target,
                         Stage::geometry, Stage::corner_detector, Stage::radiometry, Stage::light,
                         Stage::sensor,   Stage::detector,        Stage::locomotion, Stage{12}};

}  // namespace

std::string kinds_text(unsigned kinds) {
  std::string text;
  for (const KindFacts& kind : seam::effects::kinds()) {
    if (kinds & kind.bit) text += (text.empty() ? "" : ", ") + std::string(kind.name);
  }
  return text;
}

bool has_many_values(const EffectDefinition& effect) {
  constexpr size_t kMost = 20;
  return effect.parameters.size() > kMost;
}

std::string effect_help(const EffectDefinition& effect) {
  std::string text =
      fmt::format("{} (stage {})\n\n{}\n\nFormula:    {}\nSignature:  {}\nActs on:    {}\n",
                  effect.name, to_string(effect.stage), effect.help, effect.formula,
                  effect.signature, kinds_text(effect.kinds));
  if (effect.spread_only) text += "Changes the spread of measurements, not their mean.\n";
  if (const std::string why = not_pictured(effect); !why.empty())
    text += fmt::format("No picture shows it: {}\n", why);
  const std::string needs = needs_text(effect);
  if (!needs.empty()) text += fmt::format("Needs:      {}\n", needs);
  for (const std::string& line : advice_lines(effect))
    text += fmt::format("To separate it from {}\n", line);
  text += effect.parameters.empty() ? "Parameters: none\n" : "Parameters:\n";
  const size_t count = effect.parameters.size(), shown = has_many_values(effect) ? 5 : count;
  for (size_t i = 0; i < shown; ++i) {
    const Parameter& parameter = effect.parameters[i];
    text += fmt::format("  {}  {} ({})\n", parameter.name, parameter.help, range_text(parameter));
  }
  if (shown < count) {
    std::vector<std::string> names;
    for (size_t i = shown; i < count; ++i) names.push_back(effect.parameters[i].name);
    text += fmt::format("  and {} more like these: {}\n", names.size(), fmt::join(names, ", "));
  }
  if (!effect.proof.empty() && shown == count) text += "Worked examples:\n";
  for (const Proof& proof : effect.proof)
    if (shown == count) text += fmt::format("  {}\n", proof_text(effect, proof));
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
  return text + "\n`seam effects NAME` shows more about one.\n";
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
      if (const std::string why = not_pictured(*effect); !why.empty())
        text += fmt::format("- No picture shows it: {}\n", why);
      const std::string needs = needs_text(*effect);
      if (!needs.empty()) text += fmt::format("- Needs of a set: {}\n", needs);
      for (const std::string& line : advice_lines(*effect))
        text += fmt::format("- To separate it from {}\n", line);
      for (const Parameter& parameter : effect->parameters) {
        text +=
            fmt::format("- `{}`: {} ({})\n", parameter.name, parameter.help, range_text(parameter));
      }
      for (const Proof& proof : effect->proof)
        text += fmt::format("- Worked example: `{}`\n", proof_text(*effect, proof));
      text += fmt::format("\n```yaml\n{}\n```\n", effect->example);
    }
  }
  return text;
}

std::string proof_text(const EffectDefinition& effect, const Proof& proof) {
  std::vector<Quantity> values;
  for (size_t i = 0; i < proof.values.size(); ++i)
    values.push_back({effect.parameters[i].name, proof.values[i]});
  const std::string with = list_text(values), given = list_text(proof.given);
  return fmt::format("{}{}{} -> {} ({})", with, with.empty() || given.empty() ? "" : "; ", given,
                     list_text(proof.expected), proof.source);
}

}  // namespace seam::effects
