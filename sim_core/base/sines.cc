#include "sim_core/base/sines.h"

#include <sleef.h>

#include "sim_core/base/maths.h"

namespace seam::maths {

#if defined(__SSE2__)
// SLEEF's functions for pairs compute as those for single numbers do, step by step.
std::array<SineCosine, 2> sines_and_cosines(double a_rad, double b_rad) {
  const __m128d angles = _mm_set_pd(b_rad, a_rad);
  double sines[2], cosines[2];
  _mm_storeu_pd(sines, Sleef_cinz_sind2_u10sse2(angles));
  _mm_storeu_pd(cosines, Sleef_cinz_cosd2_u10sse2(angles));
  return {SineCosine{sines[0], cosines[0]}, SineCosine{sines[1], cosines[1]}};
}
#else
std::array<SineCosine, 2> sines_and_cosines(double a_rad, double b_rad) {
  return {SineCosine{sin(a_rad), cos(a_rad)}, SineCosine{sin(b_rad), cos(b_rad)}};
}
#endif

}  // namespace seam::maths
