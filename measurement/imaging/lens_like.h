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

// How far apart, at most, two models' lenses put rays that `a` sees at the image's corners and in
// the middles of its sides.
double lens_difference_px(const effects::Model& a, const effects::Model& b, int width_px,
                          int height_px);

}  // namespace seam::measurement
