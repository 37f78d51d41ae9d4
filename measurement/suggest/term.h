// Terms of a formula: what an expression effect that is suggested is built from.
#pragma once

#include <string>
#include <vector>

#include "effects/effect.h"
#include "measurement/suggest/curve.h"

namespace seam::measurement {

// A term with one coefficient in one or more of a stage's outputs, such as
// u: (u - cx) * t and v: (v - cy) * t. A curve has numbers of its own besides.
struct Term {
  struct Piece {
    std::string output;
    std::string text;  // "vx * @" with "@" in place of the curve.
    double sign = 1;
  };
  std::vector<Piece> pieces;
  Curve curve = Curve::none;
  std::string variable;         // Of the curve,
  double span = 0;              // what it goes over,
  std::vector<double> numbers;  // and the curve's own.
  double coefficient = 0;       // A start for its fit,
  double size = 0;              // and how large it may well be, where that is more.

  double parameters() const { return 1 + static_cast<double>(numbers.size()); }
  std::string label() const;  // For people, without the coefficient.
};

// What the terms add to each output, with their values, for people: "u: 0.31 * sin(5.2 * t + 0.3) -
// 0.02 * x, v: 0.1 * y"; of a gain the whole of it.
std::string formula_text(const std::vector<Term>& terms);

// The YAML of an expression effect: outputs plus coefficient times term, each coefficient with a
// neutral value of 0. `help` is a sentence.
std::string formula_yaml(const std::string& name, const std::string& stage, const std::string& help,
                         const std::vector<Term>& terms);

// The effect that this YAML defines.
std::shared_ptr<const effects::EffectDefinition> formula_effect(const std::string& yaml,
                                                                const std::string& name);

}  // namespace seam::measurement
