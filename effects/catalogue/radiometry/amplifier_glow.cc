#include <cmath>
#include <vector>

#include "effects/effect.h"
#include "effects/stages/geometry.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Pixels of a place on the sensor; beyond an edge (0.5) it counts as its mirror image.
double on_sensor(double place, int pixels) {
  const double inside = std::abs(place) > 0.5 ? std::copysign(1, place) - place : place;
  return (inside + 0.5) * (pixels - 1);
}

double glow(Values p, const ImagePoint& at) {
  const double along = p[3] * (at.u - on_sensor(p[1], at.width_px)),
               down = p[4] * (at.v - on_sensor(p[2], at.height_px));
  const double d = std::sqrt(along * along + down * down);
  return p[0] * maths::exp(-(p[5] == 1 ? d : maths::pow(d, p[5])));
}

// Corners and middles of edges, near and far.
std::vector<std::vector<double>> places() {
  std::vector<std::vector<double>> out;
  for (const double fall : {0.01, 0.05, 0.2}) {
    for (const double side : {-0.5, 0.5}) {
      for (const double other : {-0.5, 0.5}) out.push_back({0.01, side, other, fall, fall, 1});
      out.push_back({0.01, side, 0, fall, 0.1 * fall, 1});
      out.push_back({0.01, 0, side, 0.1 * fall, fall, 1});
    }
  }
  return out;
}

std::vector<Parameter> glow_parameters() {
  return {{.name = "light",
           .min = 0,
           .max = 1e6,
           .scale = 0.01,
           .help = "Light of the glow where it is brightest, in units of the illumination."},
          {.name = "u0",
           .neutral = 0.5,
           .min = -1,
           .max = 1,
           .scale = 0.05,
           .help = "Where it comes from: -0.5 is the left edge, 0.5 the right one."},
          {.name = "v0",
           .neutral = 0.5,
           .min = -1,
           .max = 1,
           .scale = 0.05,
           .help = "Where it comes from: -0.5 is the top edge, 0.5 the bottom one."},
          {.name = "fall_u_per_px",
           .neutral = 0.05,
           .min = -2,
           .max = 2,
           .scale = 0.01,
           .help = "1 / distance over which it falls to 1/e along a row, 1/px.",
           .plausible = {-1, 1, "infrared light goes through silicon farther than a pixel"}},
          {.name = "fall_v_per_px",
           .neutral = 0.05,
           .min = -2,
           .max = 2,
           .scale = 0.01,
           .help = "1 / distance over which it falls to 1/e along a column, 1/px.",
           .plausible = {-1, 1, "infrared light goes through silicon farther than a pixel"}},
          {.name = "shape",
           .neutral = 1,
           .min = 0.3,
           .max = 4,
           .scale = 0.1,
           .help = "Power of the distance in the exponent: 1 exponential, 2 Gaussian.",
           .on_demand = true,
           .plausible = {0.5, 3, "light that spreads falls as an exponential or a Gaussian does"}}};
}

}  // namespace

EffectDefinition amplifier_glow() {
  return {
      .name = "amplifier_glow",
      .stage = Stage::radiometry,
      .kinds = kPhotometry | kFrames,
      .parameters = glow_parameters(),
      .help =
          "The read-out amplifier shines on the pixels near it for as long as they are exposed.",
      .formula = "light exp(-d^shape), d^2 = (fall_u du)^2 + (fall_v dv)^2 from (u0, v0)",
      .signature = "a corner or an edge that is brighter the longer the exposure, also in the dark",
      .example = "amplifier_glow: {light: 0.05, u0: 0.5, v0: 0.5, fall_u_per_px: 0.05}",
      .starts = {{kPhotometry, StartSearch::shapes, places()}},
      .advice = {{kPhotometry,
                  {"vignetting", "uneven_lighting"},
                  "Dark frames of several exposures: a glow is there, too, and grows with the "
                  "exposure; a lens and a lamp do nothing in the dark."},
                 {kPhotometry,
                  {"dark_current", "dark_current_spread"},
                  "Dark frames, cold and warm: dark current doubles every 6 to 8 degrees in each "
                  "pixel, a glow stays where it is and hardly changes."},
                 {kPhotometry, {}, "Dark frames, the longest exposure many times the shortest."}},
      .own_light = glow,
      .proof = {{.values = {0.05, 0.5, 0.5, 0.05, 0.05, 1},
                 .given = {{"u_px", 165}, {"v_px", 127}},
                 .expected = {{"own_light", 0.0183939720585721}},
                 .source = "python: p[0] * math.exp(-p[3] * math.hypot(177 - u_px, 143 - v_px))"},
                {.values = {0.2, -0.6, 0, 0.03, 0, 2},
                 .given = {{"u_px", 15}, {"v_px", 7}},
                 .expected = {{"own_light", 0.198692095273204}},
                 .source = "python: p[0] * math.exp(-(p[3] * (u_px - 17.7))**2)"}},
  };
}

}  // namespace seam::effects
