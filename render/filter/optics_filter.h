// The lens's and the lamps' effects on an integrated image, pass by pass: the reference that the
// fused filter is tested against, and the source of stage pictures.
#pragma once

#include <vector>

#include "effects/stages/optics.h"
#include "render/base/linear_image.h"

namespace seam::render {

// Cuts off the border.
LinearImage without_border(const LinearImage& image, int border_px);

// Convolves with the separable kernel (odd length, radius at most border_px) and cuts off the
// border.
LinearImage blurred(const LinearImage& image, int border_px, const std::vector<float>& kernel);

// Multiplies row r by factors[r].
void scale_rows(LinearImage& image, const std::vector<float>& factors);

// Multiplies by the gain planes (one for each channel), as large as the image.
void apply_gain(LinearImage& image, const std::array<std::vector<float>, 3>& gain);

// (1 - f) L + f mean(L), for each channel.
void add_glare(LinearImage& image, double fraction);

// Adds the camera's own light, interleaved.
void add_own_light(LinearImage& image, const std::vector<float>& light);

}  // namespace seam::render
