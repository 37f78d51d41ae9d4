// Whether a lens is one-to-one over its image: on the way from the principal point to each pixel
// rays must go outwards as their images do. Distortion coefficients that were fitted to too few
// points fold the image over, or have a pole, where no point was; nothing can be predicted there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "effects/stages/geometry.h"

namespace seam::effects {

// The place nearest to the principal point beyond which a pixel of the image has no ray of its own.
struct LensFault {
  double u = 0, v = 0;   // Pixels.
  double angle_rad = 0;  // Of the ray there from the optical axis.
  double radius_px = 0;  // From the principal point.
  bool pole = false;     // The image of a ray runs away to infinity there.
};

// Looks along `directions` ways to the border of the image.
std::optional<LensFault> lens_fault(const Projection& projection, int directions);

// The pole inside the image of one camera's model, in a sentence; empty: there is none.
std::string lens_pole(const Model& camera, int width_px, int height_px);

// What is odd about the lenses of a model for images of this size, in sentences: folds and poles
// inside the image, near folds, a principal point outside the image. Empty for a model without a
// camera.
std::vector<std::string> lens_doubts(const Model& model, int width_px, int height_px);

}  // namespace seam::effects
