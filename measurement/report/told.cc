#include "measurement/report/told.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "measurement/check/describe.h"
#include "measurement/judge/doubted.h"
#include "measurement/judge/material.h"
#include "measurement/problem/neighbour.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

constexpr const char* kConstant = "constant";
constexpr size_t kMostLines = 8;

std::vector<std::string> factors_of(const std::string& covariate) {
  std::vector<std::string> factors;
  size_t from = 0;
  for (size_t to; (to = covariate.find('*', from)) != std::string::npos; from = to + 1)
    factors.push_back(covariate.substr(from, to - from));
  factors.push_back(covariate.substr(from));
  return factors;
}

// "sign of pan rate" of sign(pan_rate). Other names are columns of the set, and stay.
std::string words_of(std::string name) {
  const std::string sign = "sign(", rate = "_rate";
  if (name.starts_with(sign) && name.ends_with(')'))
    return "sign of " + words_of(name.substr(sign.size(), name.size() - sign.size() - 1));
  if (name.ends_with(rate)) name[name.size() - rate.size()] = ' ';
  return name;
}

std::string words_of_covariate(const std::string& covariate) {
  std::vector<std::string> words;
  for (const std::string& factor : factors_of(covariate)) words.push_back(words_of(factor));
  return fmt::format("{}", fmt::join(words, " x "));
}

// "8.02 px" of `u_px`: a residual's name ends in its unit, but those that count things.
std::string with_unit(double value, const std::string& residual) {
  const std::string unit = unit_of(residual);
  if (!unit.empty()) return fmt::format("{:.3g} {}", value, unit);
  return fmt::format("{:.3g}{}", value, residual == "dn" ? " DN" : "");
}

bool is_place_in_image(const std::string& name) {
  return name == "row" || name == "column" || name == "radius";
}

double away_from_neutral(const effects::Parameter& parameter, double value) {
  return std::isfinite(parameter.neutral) ? value - parameter.neutral : value;
}

}  // namespace

std::string two_digits(double value) {
  constexpr double kLong = 1e5;
  const double size = std::abs(value);
  return size >= 99.5 && size < kLong ? fmt::format("{:.0f}", value) : fmt::format("{:.2g}", value);
}

std::string told_value(const effects::Parameter& parameter, const effects::ParameterValue& value) {
  constexpr double kSmall = 0.1;
  if (!value.sigma && !value.free) return fmt::format("{:.6g}", value.value);
  if (is_at_bound(parameter, value.value))
    return fmt::format("{:.6g}, at the {} of its range", value.value,
                       value.value <= parameter.min ? "lower end" : "upper end");
  if (!value.sigma) return "not determined";
  // Left where it is: the data do not ask for it.
  if (*value.sigma == 0) return fmt::format("{:.6g}", value.value);
  const double away = away_from_neutral(parameter, value.value);
  // Against a typical size an error is small where the data say that there is none of it.
  if (*value.sigma >= std::abs(away))
    return *value.sigma < kSmall * parameter.scale && std::isfinite(parameter.neutral)
               ? fmt::format("{:.6g} within +- {}", parameter.neutral, two_digits(*value.sigma))
               : "not determined (+- " + two_digits(*value.sigma) + ")";
  return fmt::format("{:.6g} +- {}", value.value, two_digits(*value.sigma));
}

std::string told_value(const Model& model, const std::string& name,
                       const effects::ParameterValue& value) {
  const effects::Parameter* found = nullptr;
  for (const effects::ModelEffect& effect : model.effects()) {
    for (const effects::Parameter& parameter : effect.definition->parameters) {
      if (name == parameter.name || name == effect.definition->name + "." + parameter.name)
        found = &parameter;
    }
  }
  SEAM_CHECK(found != nullptr, "the model has no {}", name);
  return told_value(*found, value);
}

namespace {

// With the error that the fit gives it.
effects::ParameterValue fitted_value(const Assessment& assessment, const std::string& effect,
                                     size_t parameter) {
  effects::ParameterValue value{.value =
                                    assessment.model.find(effect)->parameters[parameter].value};
  if (const auto k = index_of(assessment.unknowns, {effect, parameter})) {
    value.free = true;
    if (std::isfinite(assessment.fit.sigma[*k])) value.sigma = assessment.fit.sigma[*k];
  }
  return value;
}

}  // namespace

bool determines_a_value(const Assessment& assessment, const std::string& effect) {
  const effects::ModelEffect* found = assessment.model.find(effect);
  if (found == nullptr || found->parameters.empty()) return true;
  const auto& parameters = found->definition->parameters;
  for (size_t i = 0; i < parameters.size(); ++i) {
    const effects::ParameterValue value = fitted_value(assessment, effect, i);
    const double away = away_from_neutral(parameters[i], value.value);
    if (away != 0 && (!value.free || is_at_bound(parameters[i], value.value) ||
                      (value.sigma && *value.sigma < std::abs(away))))
      return true;
  }
  return false;
}

std::string told_values(const Assessment& assessment, const std::string& effect) {
  const effects::ModelEffect& entry = *assessment.model.find(effect);
  std::vector<std::string> texts;
  for (size_t i = 0; i < entry.parameters.size(); ++i) {
    const effects::Parameter& parameter = entry.definition->parameters[i];
    texts.push_back(parameter.name + " = " +
                    told_value(parameter, fitted_value(assessment, effect, i)));
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string told_structure(const Facts& facts, const Structure& structure) {
  const std::string subject = structure.moment + " of " + structure.residual;
  if (structure.covariate == kConstant) return subject + " is not 0";
  if (structure.covariate == kNeighbour) return structure.residual + " is correlated in time";
  if (structure.covariate == kEachRun) return subject + " differs from run to run";
  if (structure.covariate.starts_with(kPixelNeighbour)) {
    const bool stays = structure.covariate == kPixelNeighbour;
    return fmt::format("{} of {} is alike in neighbouring pixels", stays ? "mean" : "noise",
                       structure.residual);
  }
  if (is_label(facts, structure.covariate))
    return fmt::format("{0} differs from {1} to {1}", subject, structure.covariate);
  return subject + " varies with " + words_of_covariate(structure.covariate);
}

std::string structure_lines(const Problem& problem, const Assessment& assessment,
                            const std::vector<Structure>& structure) {
  std::string text;
  bool cut = false;  // What all of them have at first is said once.
  for (size_t i = 0; i < std::min(kMostLines, structure.size()); ++i) {
    const Structure& s = structure[i];
    text += fmt::format("  {}: {}", told_structure(problem.facts(), s),
                        with_unit(s.strength, s.residual));
    const double units = noise_units(problem, assessment, s);
    if (std::isfinite(units)) text += fmt::format(", {} x noise", two_digits(units));
    if (s.p_value > kLeastP) text += fmt::format(", p = {:.1g}", s.p_value);
    if (s.p_value <= kLeastP && !cut) text += ", p < 1e-300";
    cut = cut || s.p_value <= kLeastP;
    text += "\n";
  }
  if (structure.size() > kMostLines)
    text += fmt::format("  and {} more (--json, --report)\n", structure.size() - kMostLines);
  return text;
}

std::string what_to_vary(const Facts& facts, const std::string& covariate) {
  const std::string sign = "sign(";
  std::vector<std::string> names;
  for (std::string name : factors_of(covariate)) {
    const bool is_none =
        name == kConstant || name == kNeighbour || name == kPixelNeighbour || name == kEachRun;
    if (is_none || is_label(facts, name)) return "";
    if (name.starts_with(sign)) name = name.substr(sign.size(), name.size() - sign.size() - 1);
    names.push_back(name);
  }
  std::vector<std::string> ways;
  for (const std::string& name : names) {
    if (is_place_in_image(name)) {
      ways.push_back("see the same things at other places in the image");
    } else if (name == "time") {
      ways.push_back("measure again in another order, so that nothing else changes with time");
    } else {
      ways.push_back("vary " + words_of(name) + " while all else stays as it is");
    }
  }
  ways.erase(std::unique(ways.begin(), ways.end()), ways.end());
  return fmt::format("{}", fmt::join(ways, ", and "));
}

}  // namespace seam::measurement
