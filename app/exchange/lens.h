// Lenses as other programs write them down: a projection and a list of coefficients. A model's
// geometry, whatever effects it is made of, is fitted to such a family over the whole image; where
// the family holds it the fit is exact, and where not the remaining error is stated in pixels.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "effects/stages/geometry.h"

namespace seam::app {

// OpenCV's terms, of which most programs use a part: x' = x (1 + k1 r2 + k2 r4 + k3 r6) / (1 + k4
// r2 + k5 r4 + k6 r6) + 2 p1 x y + p2 (r2 + 2 x^2) + s1 r2 + s2 r4, and y' alike; or the
// equidistant fisheye, r' = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
enum class LensFamily {
  pinhole,      // No coefficients.
  radtan,       // k1, k2, p1, p2.
  plumb_bob,    // k1, k2, p1, p2, k3.
  rational,     // k1, k2, p1, p2, k3, k4, k5, k6.
  thin_prism,   // The eight of rational, then s1, s2, s3, s4.
  equidistant,  // k1, k2, k3, k4.
};

size_t coefficient_count(LensFamily family);

// How other programs read a list of coefficients: a file's reader must know which.
enum class LensForm { ordinary, rational, fisheye };

LensForm form_of(LensFamily family);
std::string name_of(LensForm form);
// The form and its coefficients in the order of the file, for people.
std::string words_of(LensFamily family);

struct Lens {
  LensFamily family = LensFamily::pinhole;
  double fx_px = 0, fy_px = 0, cx_px = 0, cy_px = 0;
  std::vector<double> coefficients;  // In the order of the family.

  // Pixels of a direction in the camera's frame.
  std::array<double, 2> project(const Vec3& p_C) const;
};

struct LensFit {
  Lens lens;
  double rms_px = 0, most_px = 0;  // What it misses over the image.
  bool exact() const { return most_px < 1e-6; }
};

// A direction in the camera's frame and its pixel.
struct Sight {
  Vec3 p_C;
  double u = 0, v = 0;
};

// The lens of the family that comes nearest to a projection: least squares over rays through a grid
// of pixels. Throws InputError where the projection maps too few rays into its image.
LensFit fit_lens(const effects::Projection& projection, LensFamily family);
// The same of sights in an image of this size.
LensFit fit_lens(const std::vector<Sight>& sights, LensFamily family, double width_px,
                 double height_px);

// The first family that holds the projection exactly, a fisheye only where it stands first: within
// 40 degrees it holds many lenses of other forms. Else a perspective form: the first that
// misses by less than any calibration can show, or the nearest. A fisheye only where every
// perspective form misses visibly and the fisheye misses less than half as much: most programs read
// perspective coefficients, and the numbers of a fisheye read as k1, k2, p1, p2 are another lens.
LensFit best_lens(const effects::Projection& projection, const std::vector<LensFamily>& families);
LensFit best_lens(const std::vector<Sight>& sights, const std::vector<LensFamily>& families,
                  double width_px, double height_px);

}  // namespace seam::app
