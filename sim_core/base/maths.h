// Transcendental functions whose bits are the same on every machine.
//
// glibc picks other code for CPUs with FMA, and its double sin, cos, tan, exp, log, pow and atan2
// then differ in the last bit. All that reaches state or pixels calls these instead: SLEEF's scalar
// functions compiled without FMA (within 1.0 ulp), whose results are fixed by the IEEE operations
// alone. sqrt, fma, floor and the basic operations are exact in IEEE and need no replacement.
#pragma once

#include <cmath>

namespace seam::maths {

inline constexpr double kPi = 3.14159265358979323846;

double sin(double x_rad);
double cos(double x_rad);
double tan(double x_rad);
double asin(double x);
double acos(double x);
double atan(double x);
double atan2(double y, double x);
// Within 3.5 ulp, in a third of the time: for lenses, which ask for an angle of each point.
double quick_atan2(double y, double x);
double exp(double x);
double expm1(double x);
double log(double x);
double log1p(double x);
double pow(double x, double y);

// Length of the vector (x, y); hypot's last bit differs between machines.
inline double length(double x, double y) {
  return std::sqrt(x * x + y * y);
}

// Angle wrapped into (-pi, pi].
double wrap_angle(double angle_rad);

}  // namespace seam::maths
