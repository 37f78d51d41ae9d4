// Units: micro-radians and the like, as integers.
#ifndef SEAM_OPEN_R_OUNITS_H
#define SEAM_OPEN_R_OUNITS_H

#include <Types.h>

typedef slongword Length;
typedef slongword Mass;
typedef slongword Angle;
typedef slongword Temperature;
typedef slongword Velocity;
typedef slongword Acceleration;
typedef slongword AngularVelocity;
typedef slongword Force;
typedef slongword Percentage;

const slongword oradiansPI = 3141592;
const slongword oradiansPI_2 = 1570796;
const slongword oradiansPI_4 = 785398;

inline slongword micro(double value) {
  return static_cast<slongword>(value * 1e6);
}
inline double radians(double degrees) {
  return degrees * (3.14159265358979323846 / 180);
}
inline double degrees(double radians) {
  return radians * (180 / 3.14159265358979323846);
}
// Micro-radians.
inline slongword oradians(double degrees) {
  return micro(radians(degrees));
}

#endif
