// One family of lenses in the place of another: where the images are most alike.
#pragma once

#include <optional>
#include <vector>

#include "effects/model.h"

namespace seam::measurement {

// The values of `in` with which it maps rays up to this angle from the axis most nearly as the
// model's lens does, in the place of what leaves it no room; nothing where it sees no such ray.
std::optional<std::vector<double>> lens_like(const effects::Model& model,
                                             const effects::EffectDefinition& in, int width_px,
                                             int height_px, double most_rad);

// The same for the lens of splines, over the whole image, which its control points cover; nothing
// where the model's lens does not fill the image.
std::optional<std::vector<double>> spline_lens_like(const effects::Model& model,
                                                    const effects::EffectDefinition& splines,
                                                    int width_px, int height_px);

// How far apart, at most, two models' lenses put rays that `a` sees at the image's corners and in
// the middles of its sides.
double lens_difference_px(const effects::Model& a, const effects::Model& b, int width_px,
                          int height_px);

}  // namespace seam::measurement
