#include "measurement/suggest/term.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "effects/formulas/formula_stages.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"

namespace seam::measurement {
namespace {

// A piece's text with the curve in its place.
std::string with_curve(std::string text, const std::string& curve) {
  const size_t at = text.find('@');
  return at == std::string::npos ? text : text.replace(at, 1, curve);
}

// What is added to each output, in the order in which they come.
class Sums {
 public:
  // With `beside` each begins with what changes nothing; a gain always does.
  explicit Sums(bool beside) : beside_(beside) {}
  void add(const std::string& output, bool minus, const std::string& what) {
    auto at = std::find_if(sums_.begin(), sums_.end(),
                           [&](const auto& sum) { return sum.first == output; });
    if (at == sums_.end()) {
      const std::string same = effects::formula_without_change(output);
      const bool begins = same == "1" || (beside_ && same != "0");
      at = sums_.insert(at, {output, begins ? same : ""});
    }
    at->second += (at->second.empty() ? minus ? "-" : "" : minus ? " - " : " + ") + what;
  }
  const std::vector<std::pair<std::string, std::string>>& all() const { return sums_; }

 private:
  bool beside_;
  std::vector<std::pair<std::string, std::string>> sums_;
};

// "0.3 * text", or the number alone.
std::string times(const std::string& number, const std::string& text) {
  return text == "1" ? number : number + " * " + text;
}

}  // namespace

std::string Term::label() const {
  std::vector<std::string> parts;
  for (const Piece& piece : pieces)
    parts.push_back(piece.output + (piece.sign < 0 ? ": -" : ": ") +
                    with_curve(piece.text, curve_text(curve, variable, numbers)));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string formula_text(const std::vector<Term>& terms) {
  Sums sums(false);
  for (const Term& term : terms) {
    const std::string curve = curve_text(term.curve, term.variable, term.numbers);
    for (const Term::Piece& piece : term.pieces)
      sums.add(
          piece.output, term.coefficient * piece.sign < 0,
          times(fmt::format("{:.3g}", std::abs(term.coefficient)), with_curve(piece.text, curve)));
  }
  std::vector<std::string> texts;
  for (const auto& [output, sum] : sums.all()) texts.push_back(output + ": " + sum);
  return fmt::format("{}", fmt::join(texts, ", "));
}

std::string formula_yaml(const std::string& name, const std::string& stage, const std::string& help,
                         const std::vector<Term>& terms) {
  Sums sums(true);
  std::string parameters;
  const auto parameter = [&](const std::string& key, double value, double neutral, double reach,
                             double scale) {
    parameters += fmt::format(
        "      {}: {{value: {:.8g}, neutral: {:.8g}, min: {:.6g}, max: {:.6g}, scale: {:.6g}}}\n",
        key, value, neutral, neutral - reach, neutral + reach, scale);
  };
  for (size_t i = 0; i < terms.size(); ++i) {
    const Term& term = terms[i];
    const std::string number = terms.size() == 1 ? "" : std::to_string(i + 1);
    const std::string curve = curve_formula(term.curve, term.variable, term.numbers, number);
    // Signs stand in the formula, so that coefficients are positive.
    for (const Term::Piece& piece : term.pieces)
      sums.add(piece.output, term.coefficient * piece.sign < 0,
               times("k" + number, with_curve(piece.text, curve)));
    // Twenty times what was found is out of the question; a fit starts at a twentieth of the scale.
    const double size = std::max({std::abs(term.coefficient), term.size, 1e-12});
    parameter("k" + number, size, 0, 20 * size, 20 * size);
    const auto own = curve_numbers(term.curve, term.numbers, term.span, number);
    for (size_t k = 0; k < own.size(); ++k)
      parameter(own[k].name, term.numbers[k], term.numbers[k], own[k].reach, own[k].scale);
  }
  std::string text =
      fmt::format("# {}\n# What it means is for you to find.\neffects:\n  {}:\n    stage: {}\n",
                  help, name, stage);
  for (const auto& [output, sum] : sums.all()) text += fmt::format("    {}: \"{}\"\n", output, sum);
  return text + "    parameters:\n" + parameters;
}

std::shared_ptr<const effects::EffectDefinition> formula_effect(const std::string& yaml,
                                                                const std::string& name) {
  return effects::expression_effect(
      name, ConfigNode::from_text(yaml, "suggestion").at("effects").at(name));
}

}  // namespace seam::measurement
