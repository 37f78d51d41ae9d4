// A sine and a cosine by least squares.
#pragma once

namespace seam::measurement {

// By how much a sine and a cosine, as columns, lower a sum of squares, and with which factors.
struct TwoColumns {
  double gain = 0, sine = 0, cosine = 0;
};

inline TwoColumns least_squares(double ss, double sc, double cc, double with_s, double with_c) {
  constexpr double kLeast = 1e-6;
  const double determinant = ss * cc - sc * sc;
  if (!(determinant > kLeast * ss * cc)) return {};
  TwoColumns out{.sine = (cc * with_s - sc * with_c) / determinant,
                 .cosine = (ss * with_c - sc * with_s) / determinant};
  out.gain = out.sine * with_s + out.cosine * with_c;
  return out;
}

}  // namespace seam::measurement
