// Curves of one variable that have numbers of their own, which a formula may be made of.
#pragma once

#include <string>
#include <vector>

namespace seam::measurement {

enum class Curve {
  none,
  wave,   // sin(w v + p); numbers: w in radians a unit of v, p in radians.
  decay,  // exp(-v / s); number: s in units of v.
  rise,   // 1 - exp(-v / s); number: s.
  from,   // 1 where v > s, else 0; number: s.
  until,  // 1 where v < s, else 0; number: s.
  line,   // v - s; number: s.
  above,  // max(v - s, 0); number: s.
  below,  // max(s - v, 0); number: s.
  bump,   // exp(-((v - s) / b)^2); numbers: s, b.
};

// Whether this number is a size, sought by factors, and no place.
bool is_size(Curve curve, size_t number);

// Whether a fit can move them. A step's place it cannot: between two observations nothing changes.
bool is_fitted(Curve curve);

// The curve for people, with its values.
std::string curve_text(Curve curve, const std::string& variable,
                       const std::vector<double>& numbers);

// A number of a curve as a parameter of an effect: its name, how far a fit may take it, and its
// scale.
struct CurveNumber {
  std::string name;
  double reach = 0, scale = 0;
};
// `span`: of the variable. Empty for a curve whose numbers are not fitted.
std::vector<CurveNumber> curve_numbers(Curve curve, const std::vector<double>& numbers, double span,
                                       const std::string& suffix);
// The curve as a formula of these parameters, or of its values where they are not fitted.
std::string curve_formula(Curve curve, const std::string& variable,
                          const std::vector<double>& numbers, const std::string& suffix);

}  // namespace seam::measurement
