// Levels whose stated light cannot be right: their means stand off the curve that all others share.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {

struct WrongLight {
  size_t level = 0;
  double ratio = 1;  // The light that the level had over what is stated.
  double sigma = 0;
};

// By the statistics of whole frames. The curve may be any smooth one (a power, a cubic), so that
// nothing is said of few levels or where the others, too, scatter.
std::vector<WrongLight> wrong_lights(const PhotometryData& data);

struct OddFrame {
  size_t frame, other;              // One as its level mostly is.
  double above_dark, as_the_level;  // DN.
};

// Frames that had another light than the rest of their level by far: what is stated of one of them
// is not its own, unless the lamp flickers.
std::vector<OddFrame> odd_frames(const PhotometryData& data);

struct BrightDark {
  size_t level;
  double above_dark;  // DN.
};

// Levels that had light by far though none is stated.
std::vector<BrightDark> bright_darks(const PhotometryData& data);

struct FallingLight {
  size_t level, other;             // The other has less light stated, and more to show.
  double above_dark, other_above;  // DN.
};

// Where most levels would have to be left out for more light not to be darker; the worst of them.
std::optional<FallingLight> falling_lights(const PhotometryData& data);

}  // namespace seam::measurement
