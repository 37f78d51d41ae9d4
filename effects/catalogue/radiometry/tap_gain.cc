#include <cmath>

#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {
namespace {

bool is_odd(double place) {
  return std::fmod(std::floor(place + 0.5), 2) == 1;
}

Parameter gain_of(const std::string& name, const std::string& which) {
  return {.name = name,
          .min = -0.9,
          .max = 9,
          .scale = 0.01,
          .help = "Gain of " + which + ", less 1.",
          .plausible = {-0.1, 0.1,
                        "outputs of one sensor are matched to within some per cent by its maker"}};
}

}  // namespace

EffectDefinition tap_gain() {
  return {
      .name = "tap_gain",
      .stage = Stage::radiometry,
      .kinds = kPhotometry,
      .parameters = {gain_of("right_half", "the right half over the left one"),
                     gain_of("lower_half", "the lower half over the upper one"),
                     gain_of("odd_columns", "columns 1, 3, 5, ... over 0, 2, 4, ..."),
                     gain_of("odd_rows", "rows 1, 3, 5, ... over 0, 2, 4, ...")},
      .help =
          "The sensor is read by several amplifiers or converters (taps) whose gains differ: "
          "halves of the image, or every second column or row.",
      .formula =
          "gain = (1 + right_half) (1 + lower_half) (1 + odd_columns) (1 + odd_rows), each "
          "where it applies",
      .signature =
          "a step in the middle of the image, or stripes of two pixels, in proportion to "
          "the light",
      .example = "tap_gain: {right_half: 0.02, lower_half: 0, odd_columns: 0, odd_rows: 0}",
      .needs = {Need::light},
      .advice = {{kPhotometry,
                  {"uneven_lighting", "vignetting"},
                  "turn the camera by a half turn before the same light: taps turn with it"}},
      .gain =
          [](Values p, const ImagePoint& at) {
            double gain = 1;
            if (at.u >= 0.5 * at.width_px - 0.5) gain *= 1 + p[0];
            if (at.v >= 0.5 * at.height_px - 0.5) gain *= 1 + p[1];
            if (is_odd(at.u)) gain *= 1 + p[2];
            if (is_odd(at.v)) gain *= 1 + p[3];
            return gain;
          },
      .proof = {{.values = {0.02, -0.01, 0.003, 0.005},
                 .given = {{"u_px", 89}, {"v_px", 71}},
                 .expected = {{"gain", 1.0281753}},
                 .source = "python: (1 + p[0]) * (1 + p[2]) * (1 + p[3])"},
                {.values = {0.02, -0.01, 0.003, 0.005},
                 .given = {{"u_px", 88}, {"v_px", 72}},
                 .expected = {{"gain", 0.99}},
                 .source = "python: 1 + p[1]"}},
  };
}

}  // namespace seam::effects
