// Terms of a formula: what an expression effect that is suggested is built from.
#pragma once

#include <string>
#include <vector>

#include "effects/effect.h"
#include "effects/model.h"
#include "measurement/judge/decisions.h"
#include "measurement/problem/problem.h"

namespace seam::measurement {

// A term with one coefficient in one or more of a stage's outputs, such as
// u: (u - cx) * t and v: (v - cy) * t. A wave has a frequency and a phase besides.
struct Term {
  struct Piece {
    std::string output;
    std::string text;
  };
  std::vector<Piece> pieces;
  std::string variable;  // Of a wave: pieces hold "sin(@)", with @ the angle.
  double frequency = 0;  // Radians for each unit of the variable.
  double phase = 0;
  double coefficient = 0;  // A start for its fit.

  bool is_wave() const { return !variable.empty(); }
  double parameters() const { return is_wave() ? kWaveParameters : 1; }
  std::string label() const;  // For people, without the coefficient.
};

// What formulas of one stage may be made of.
struct Vocabulary {
  std::string stage;
  std::vector<std::string> outputs;
  std::vector<std::string> variables;  // Whose waves are looked for, in each output.
  std::vector<Term> terms;
};

// The stages whose formulas act on a kind; `columns` are the further columns of a servo log.
std::vector<Vocabulary> vocabularies(effects::Kind kind, const std::vector<std::string>& columns);

// What the terms add to each output, with their values, for people: "u: 0.31 * sin(5.2 * t + 0.3) -
// 0.02 * x, v: 0.1 * y".
std::string formula_text(const std::vector<Term>& terms);

// The YAML of an expression effect: outputs plus coefficient times term, each coefficient with a
// neutral value of 0. `help` is a sentence.
std::string formula_yaml(const std::string& name, const std::string& stage, const std::string& help,
                         const std::vector<Term>& terms);

// The effect that this YAML defines.
std::shared_ptr<const EffectDefinition> formula_effect(const std::string& yaml,
                                                       const std::string& name);

}  // namespace seam::measurement
