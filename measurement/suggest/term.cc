#include "measurement/suggest/term.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// Products of up to `degree` of the variables, each in the given order; the empty product is "1".
std::vector<std::string> products(const std::vector<std::string>& variables, int degree) {
  std::vector<std::string> all = {"1"}, last = {""};
  std::vector<size_t> first = {0};
  for (int d = 0; d < degree; ++d) {
    std::vector<std::string> next;
    std::vector<size_t> next_first;
    for (size_t i = 0; i < last.size(); ++i) {
      for (size_t k = first[i]; k < variables.size(); ++k) {
        next.push_back(last[i].empty() ? variables[k] : last[i] + " * " + variables[k]);
        next_first.push_back(k);
      }
    }
    all.insert(all.end(), next.begin(), next.end());
    last = std::move(next), first = std::move(next_first);
  }
  return all;
}

void in_each_output(Vocabulary& vocabulary, const std::vector<std::string>& texts) {
  for (const std::string& output : vocabulary.outputs) {
    for (const std::string& text : texts) vocabulary.terms.push_back({.pieces = {{output, text}}});
  }
}

void append(std::vector<std::string>& list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

Vocabulary geometry() {
  Vocabulary all{.stage = "geometry", .outputs = {"u", "v"}, .variables = {"u", "v", "t"}};
  // Along the radius: one coefficient for both axes.
  for (const char* factor :
       {"t", "t * t", "r2", "r2 * t", "r2 * r2", "r2 * r2 * r2", "sign(x)", "sign(y)"}) {
    all.terms.push_back({.pieces = {{"u", std::string("(u - cx) * ") + factor},
                                    {"v", std::string("(v - cy) * ") + factor}}});
  }
  all.terms.push_back({.pieces = {{"u", "(u - cx)"}, {"v", "(v - cy)"}}});
  // Across it: a turn of the image.
  for (const char* factor : {"t", "r2"}) {
    all.terms.push_back({.pieces = {{"u", std::string("(cy - v) * ") + factor},
                                    {"v", std::string("(u - cx) * ") + factor}}});
  }
  std::vector<std::string> texts = products({"x", "y", "t"}, 3);
  append(texts, {"r2 * x * x", "r2 * x * y", "r2 * y * y", "r2 * r2 * x", "r2 * r2 * y", "sign(x)",
                 "sign(y)", "sign(x) * y", "sign(y) * x", "abs(x)", "abs(y)", "1 / (1 + t)"});
  in_each_output(all, texts);
  return all;
}

Vocabulary joint(const std::vector<std::string>& columns) {
  Vocabulary all{.stage = "joint", .outputs = {"q"}, .variables = {"q", "t"}};
  std::vector<std::string> texts = products({"q", "t"}, 3);
  append(texts, {"rate", "rate * q", "rate * t", "rate * rate", "rate * abs(rate)", "sign(rate)",
                 "sign(rate) * q", "sign(rate) * t", "sign(rate) * q * q", "abs(rate)", "abs(q)",
                 "sign(q)", "sin(q)", "cos(q)", "sin(q) * t", "cos(q) * t", "(command - q)",
                 "sign(command - q)", "sqrt(abs(rate)) * sign(rate)"});
  for (const std::string& column : columns) {
    for (const char* factor :
         {"", " * q", " * t", " * rate", " * sign(rate)", " * sin(q)", " * cos(q)"})
      texts.push_back(column + factor);
  }
  in_each_output(all, texts);
  return all;
}

Vocabulary detector() {
  Vocabulary all{
      .stage = "detector", .outputs = {"range", "bearing"}, .variables = {"range", "bearing", "t"}};
  std::vector<std::string> texts = products({"range", "bearing", "t"}, 3);
  append(texts, {"sign(bearing)", "abs(bearing)", "sign(bearing) * range", "abs(bearing) * range",
                 "sqrt(range)", "1 / range"});
  in_each_output(all, texts);
  return all;
}

Vocabulary locomotion() {
  Vocabulary all{
      .stage = "locomotion", .outputs = {"vx", "vy", "omega"}, .variables = {"theta", "t"}};
  std::vector<std::string> texts = products({"vx", "vy", "omega"}, 3);
  append(texts, {"vx * t", "vy * t", "omega * t", "abs(vx)", "abs(vy)", "abs(omega)", "sign(vx)",
                 "sign(vy)", "sign(omega)", "vx * abs(omega)", "vx * sin(theta)", "vx * cos(theta)",
                 "sin(theta)", "cos(theta)"});
  std::erase(texts, "1");  // A body that stands does not creep.
  in_each_output(all, texts);
  return all;
}

}  // namespace

std::string Term::label() const {
  std::vector<std::string> parts;
  for (const Piece& piece : pieces) {
    std::string text = piece.text;
    const size_t at = text.find('@');
    if (at != std::string::npos)
      text.replace(at, 1, fmt::format("{:.4g} * {} + {:.3g}", frequency, variable, phase));
    parts.push_back(piece.output + ": " + text);
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string formula_text(const std::vector<Term>& terms) {
  std::vector<std::string> outputs, sums;
  for (const Term& term : terms) {
    for (const Term::Piece& piece : term.pieces) {
      const size_t at = std::find(outputs.begin(), outputs.end(), piece.output) - outputs.begin();
      if (at == outputs.size()) outputs.push_back(piece.output), sums.emplace_back();
      std::string text = piece.text;
      if (term.is_wave())
        text.replace(text.find('@'), 1,
                     fmt::format("2 * pi * {} / {:.4g} {} {:.2g}", term.variable,
                                 2 * maths::kPi / term.frequency, term.phase < 0 ? '-' : '+',
                                 std::abs(term.phase)));
      const bool first = sums[at].empty();
      sums[at] += fmt::format("{}{:.3g}{}",
                              term.coefficient < 0 ? first ? "-" : " - "
                              : first              ? ""
                                                   : " + ",
                              std::abs(term.coefficient), text == "1" ? "" : " * " + text);
    }
  }
  for (size_t i = 0; i < outputs.size(); ++i) sums[i] = outputs[i] + ": " + sums[i];
  return fmt::format("{}", fmt::join(sums, ", "));
}

std::vector<Vocabulary> vocabularies(effects::Kind kind, const std::vector<std::string>& columns) {
  std::vector<Vocabulary> all;
  for (const effects::Stage stage : effects::kind_facts(kind).formula_stages) {
    switch (stage) {
      case effects::Stage::geometry:
        all.push_back(geometry());
        break;
      case effects::Stage::joint:
        all.push_back(joint(columns));
        break;
      case effects::Stage::detector:
        all.push_back(detector());
        break;
      case effects::Stage::locomotion:
        all.push_back(locomotion());
        break;
      default:
        SEAM_CHECK(false, "no words for formulas of stage {}", to_string(stage));
    }
  }
  return all;
}

std::string formula_yaml(const std::string& name, const std::string& stage, const std::string& help,
                         const std::vector<Term>& terms) {
  std::vector<std::string> outputs;
  std::vector<std::string> formulas;
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
    for (const Term::Piece& piece : term.pieces) {
      size_t at = std::find(outputs.begin(), outputs.end(), piece.output) - outputs.begin();
      if (at == outputs.size()) outputs.push_back(piece.output), formulas.push_back(piece.output);
      std::string text = piece.text;
      if (term.is_wave())
        text.replace(text.find('@'), 1,
                     fmt::format("w{} * {} + p{}", number, term.variable, number));
      // Signs stand in the formula, so that coefficients are positive.
      formulas[at] +=
          (term.coefficient < 0 ? " - k" : " + k") + number + (text == "1" ? "" : " * " + text);
    }
    // Twenty times what was found is out of the question; a fit starts at a twentieth of the scale.
    const double size = std::max(std::abs(term.coefficient), 1e-12);
    parameter("k" + number, size, 0, 20 * size, 20 * size);
    if (!term.is_wave()) continue;
    parameter("w" + number, term.frequency, term.frequency, 0.3 * term.frequency,
              1e-3 * term.frequency);
    parameter("p" + number, term.phase, term.phase, 3.15, 0.02);
  }
  std::string text =
      fmt::format("# {}\n# What it means is for you to find.\neffects:\n  {}:\n    stage: {}\n",
                  help, name, stage);
  for (size_t i = 0; i < outputs.size(); ++i)
    text += fmt::format("    {}: \"{}\"\n", outputs[i], formulas[i]);
  return text + "    parameters:\n" + parameters;
}

std::shared_ptr<const EffectDefinition> formula_effect(const std::string& yaml,
                                                       const std::string& name) {
  return effects::expression_effect(
      name, ConfigNode::from_text(yaml, "suggestion").at("effects").at(name));
}

}  // namespace seam::measurement
