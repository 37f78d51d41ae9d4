// Sines and cosines of several angles at once, in less time than one after the other: the bits of
// maths::sin and maths::cos.
#pragma once

#include <array>
#include <cstddef>

namespace seam::maths {

struct SineCosine {
  double sin, cos;
};

// Of two angles.
std::array<SineCosine, 2> sines_and_cosines(double a_rad, double b_rad);

inline std::array<SineCosine, 3> sines_and_cosines(double a_rad, double b_rad, double c_rad) {
  const auto ab = sines_and_cosines(a_rad, b_rad), cc = sines_and_cosines(c_rad, c_rad);
  return {ab[0], ab[1], cc[0]};
}

}  // namespace seam::maths
