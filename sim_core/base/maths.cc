#include "sim_core/base/maths.h"

#include <sleef.h>

#include <cmath>

namespace seam::maths {

double sin(double x_rad) {
  return Sleef_cinz_sind1_u10purec(x_rad);
}
double cos(double x_rad) {
  return Sleef_cinz_cosd1_u10purec(x_rad);
}
double tan(double x_rad) {
  return Sleef_cinz_tand1_u10purec(x_rad);
}
double asin(double x) {
  return Sleef_cinz_asind1_u10purec(x);
}
double acos(double x) {
  return Sleef_cinz_acosd1_u10purec(x);
}
double atan(double x) {
  return Sleef_cinz_atand1_u10purec(x);
}
double atan2(double y, double x) {
  return Sleef_cinz_atan2d1_u10purec(y, x);
}
double quick_atan2(double y, double x) {
  return Sleef_cinz_atan2d1_u35purec(y, x);
}
double exp(double x) {
  return Sleef_cinz_expd1_u10purec(x);
}
double expm1(double x) {
  return Sleef_cinz_expm1d1_u10purec(x);
}
double log(double x) {
  return Sleef_cinz_logd1_u10purec(x);
}
double log1p(double x) {
  return Sleef_cinz_log1pd1_u10purec(x);
}
double pow(double x, double y) {
  return Sleef_cinz_powd1_u10purec(x, y);
}

double wrap_angle(double angle_rad) {
  // Nearly all are wrapped already; -0 becomes 0 as it does below.
  constexpr double kInside_rad = 3;
  if (std::abs(angle_rad) < kInside_rad) return angle_rad + 0.0;
  const double wrapped = angle_rad - 2.0 * kPi * std::ceil((angle_rad - kPi) / (2.0 * kPi));
  return wrapped <= -kPi ? kPi : wrapped;
}

}  // namespace seam::maths
