// A formula over named variables, compiled once, evaluated from any thread. Functions come from
// sim_core/base/maths.h, so that results are the same bits on every machine.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace seam::effects {

// What stands in a variable's name beside letters, digits and `_`.
enum class Names : uint8_t { plain, dotted };  // dotted: `red1.ball_area_px`.

class Formula {
 public:
  // Throws InputError for a syntax error or an unknown name, with the nearest known one.
  Formula(const std::string& text, std::vector<std::string> variables, Names names = Names::plain);

  // The value where the variables have these values, in the order given at construction.
  double operator()(std::span<const double> values) const;

  const std::string& text() const { return text_; }
  // Names in a formula's text that are no functions, sorted; throws InputError for a syntax error.
  static std::vector<std::string> names_in(const std::string& text, Names names = Names::plain);

 private:
  std::string text_;
  std::vector<std::string> variables_;
  Names names_;
  uint64_t id_;  // Key of each thread's own parser.
};

}  // namespace seam::effects
