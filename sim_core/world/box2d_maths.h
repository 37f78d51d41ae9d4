// Machine-independent single-precision sine and cosine for Box2D (box2d_maths.cc).
#pragma once

namespace seam {

// The sine that Box2D uses. Whoever calls it has the replacement of sinf, cosf and sincosf linked
// into the program.
float box2d_sine(float x);

}  // namespace seam
