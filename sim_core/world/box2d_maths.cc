// Box2D turns its bodies by libm's sinf and cosf, and glibc picks other code for these on CPUs with
// FMA, whose last bit may differ. These definitions stand before libm's for the whole program,
// Box2D's shared library included, so that its bodies move by the same bits on every machine.
#include "sim_core/world/box2d_maths.h"

#include <cmath>

#include "sim_core/base/maths.h"

extern "C" {

float sinf(float x) noexcept {
  return static_cast<float>(seam::maths::sin(static_cast<double>(x)));
}

float cosf(float x) noexcept {
  return static_cast<float>(seam::maths::cos(static_cast<double>(x)));
}

void sincosf(float x, float* sine, float* cosine) noexcept {
  *sine = sinf(x);
  *cosine = cosf(x);
}

}  // extern "C"

namespace seam {

float box2d_sine(float x) {
  return sinf(x);
}

}  // namespace seam
