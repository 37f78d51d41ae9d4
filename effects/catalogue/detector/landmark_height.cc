#include <algorithm>
#include <cmath>

#include "effects/effect.h"
#include "effects/stages/detector.h"

namespace seam::effects {

EffectDefinition landmark_height() {
  return {
      .name = "landmark_height",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters = {{.name = "z_m",
                      .min = -100,
                      .max = 100,
                      .scale = 0.5,
                      .help = "How much higher above the detector all landmarks lie than the set "
                              "says, metres. Where it has no heights, the sign is open.",
                      .plausible = {-30, 30, "beacons hang under ceilings of 2 to 20 m"}}},
      .help =
          "Landmarks hang above the plane of the robot, or the robot's tag higher or lower than "
          "stated: ranges are distances in space.",
      .formula = "sqrt(range^2 - above^2 + (above + z)^2), above as the set has it, or 0",
      .signature = "ranges too long near a landmark, right far from it",
      .example = "landmark_height: {z_m: 2.2}",
      .needs = {Need::distances},
      .starts = {{kLandmarks,
                  StartSearch::best_listed,
                  {{0.1}, {0.3}, {1}, {2}, {4}, {-0.3}, {-1}}}},
      .advice = {{kLandmarks,
                  {"range_offset", "range_scale"},
                  "Pass close by a landmark and go far from it: a height shows near it alone."},
                 {kLandmarks, {}, "Pass close by the landmarks, or state their heights (z_m)."}},
      .detector =
          [](Values p, Detection& seen) {
            if (p[0] == 0) return;
            const double above = seen.above_m + p[0];
            const double plane2 = seen.range_m * seen.range_m - seen.above_m * seen.above_m;
            seen.range_m = std::sqrt(std::max(0.0, plane2) + above * above);
            seen.above_m = above;
          },
      .proof = {{.values = {2.2},
                 .given = {{"range_m", 3}},
                 .expected = {{"range_m", 3.72021504754765}},
                 .source = "python: math.sqrt(9 + p[0]**2)"},
                {.values = {-0.5},
                 .given = {{"range_m", 2}, {"above_m", 1.2}},
                 .expected = {{"range_m", 1.7464249196573}},
                 .source = "python: math.sqrt(4 - 1.44 + (1.2 + p[0])**2)"}},
  };
}

}  // namespace seam::effects
