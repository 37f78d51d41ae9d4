#include "measurement/suggest/curve.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "effects/formulas/formula.h"

namespace seam::measurement {
namespace {

struct Known {
  Curve curve;
  std::vector<double> numbers;
  double (*at)(double v);
};

const std::vector<Known>& all() {
  static const std::vector<Known> curves = {
      {Curve::wave, {3, 0.4}, [](double v) { return std::sin(3 * v + 0.4); }},
      {Curve::decay, {0.7}, [](double v) { return std::exp(-v / 0.7); }},
      {Curve::rise, {0.7}, [](double v) { return 1 - std::exp(-v / 0.7); }},
      {Curve::from, {0.5}, [](double v) { return v > 0.5 ? 1.0 : 0.0; }},
      {Curve::until, {0.5}, [](double v) { return v < 0.5 ? 1.0 : 0.0; }},
      {Curve::line, {0.5}, [](double v) { return v - 0.5; }},
      {Curve::bump, {0.5, 0.2}, [](double v) { return std::exp(-25 * (v - 0.5) * (v - 0.5)); }},
      {Curve::above, {-0.5}, [](double v) { return std::max(v + 0.5, 0.0); }},
      {Curve::below, {0.5}, [](double v) { return std::max(0.5 - v, 0.0); }},
  };
  return curves;
}

TEST(Curve, ItsFormulaIsTheCurve) {
  for (const Known& known : all()) {
    std::vector<std::string> names = {"v"};
    std::vector<double> inputs = {0};
    const auto numbers = curve_numbers(known.curve, known.numbers, 2, "7");
    EXPECT_EQ(numbers.size(), is_fitted(known.curve) ? known.numbers.size() : 0);
    for (size_t i = 0; i < numbers.size(); ++i)
      names.push_back(numbers[i].name), inputs.push_back(known.numbers[i]);
    const effects::Formula formula(curve_formula(known.curve, "v", known.numbers, "7"), names);
    const effects::Formula said(curve_text(known.curve, "v", known.numbers), {"v"});
    for (const double v : {-0.8, -0.1, 0.3, 0.9}) {
      inputs[0] = v;
      EXPECT_NEAR(formula(inputs), known.at(v), 1e-12);
      // With four digits, of a phase two.
      EXPECT_NEAR(said(std::array{v}), known.at(v), 2e-3);
    }
  }
}

}  // namespace
}  // namespace seam::measurement
