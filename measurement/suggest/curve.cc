#include "measurement/suggest/curve.h"

#include <fmt/format.h>

#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::measurement {
namespace {

// "v - 0.3", "v + 0.3", "v".
std::string less(const std::string& variable, double place) {
  if (place == 0) return variable;
  return fmt::format("{} {} {:.4g}", variable, place < 0 ? '+' : '-', std::abs(place));
}

}  // namespace

bool is_size(Curve curve, size_t number) {
  return curve == Curve::decay || curve == Curve::rise || (curve == Curve::bump && number == 1);
}

bool is_fitted(Curve curve) {
  return curve != Curve::none && curve != Curve::from && curve != Curve::until;
}

std::string curve_text(Curve curve, const std::string& variable,
                       const std::vector<double>& numbers) {
  switch (curve) {
    case Curve::wave:
      return fmt::format("sin(2 * pi * {} / {:.4g} {} {:.2g})", variable,
                         2 * maths::kPi / numbers[0], numbers[1] < 0 ? '-' : '+',
                         std::abs(numbers[1]));
    case Curve::decay:
      return fmt::format("exp(-{} / {:.4g})", variable, numbers[0]);
    case Curve::rise:
      return fmt::format("(1 - exp(-{} / {:.4g}))", variable, numbers[0]);
    case Curve::from:
      return fmt::format("(0.5 + 0.5 * sign({}))", less(variable, numbers[0]));
    case Curve::until:
      return fmt::format("(0.5 - 0.5 * sign({}))", less(variable, numbers[0]));
    case Curve::line:
      return fmt::format("({})", less(variable, numbers[0]));
    case Curve::above:
      return fmt::format("max({}, 0)", less(variable, numbers[0]));
    case Curve::below:
      return fmt::format("max({:.4g} - {}, 0)", numbers[0], variable);
    case Curve::bump:
      return fmt::format("exp(-(({}) / {:.4g})^2)", less(variable, numbers[0]), numbers[1]);
    default:
      return "1";
  }
}

std::vector<CurveNumber> curve_numbers(Curve curve, const std::vector<double>& numbers, double span,
                                       const std::string& suffix) {
  switch (curve) {
    case Curve::wave:
      return {{"w" + suffix, 0.3 * numbers[0], 1e-3 * numbers[0]}, {"p" + suffix, 3.15, 0.02}};
    case Curve::decay:
    case Curve::rise:
      return {{"s" + suffix, 0.9 * numbers[0], 0.1 * numbers[0]}};
    case Curve::line:
    case Curve::above:
    case Curve::below:
      return {{"s" + suffix, 0.3 * span, 1e-3 * span}};
    case Curve::bump:
      return {{"s" + suffix, 0.3 * span, 1e-3 * span},
              {"b" + suffix, 0.9 * numbers[1], 0.1 * numbers[1]}};
    default:
      return {};
  }
}

std::string curve_formula(Curve curve, const std::string& variable,
                          const std::vector<double>& numbers, const std::string& suffix) {
  switch (curve) {
    case Curve::wave:
      return fmt::format("sin(w{0} * {1} + p{0})", suffix, variable);
    case Curve::decay:
      return fmt::format("exp(-{} / s{})", variable, suffix);
    case Curve::rise:
      return fmt::format("(1 - exp(-{} / s{}))", variable, suffix);
    case Curve::line:
      return fmt::format("({} - s{})", variable, suffix);
    case Curve::above:
      return fmt::format("max({} - s{}, 0)", variable, suffix);
    case Curve::below:
      return fmt::format("max(s{} - {}, 0)", suffix, variable);
    case Curve::bump:
      return fmt::format("exp(-(({1} - s{0}) / b{0})^2)", suffix, variable);
    default:
      return curve_text(curve, variable, numbers);
  }
}

}  // namespace seam::measurement
