#include <algorithm>
#include <cmath>

#include "effects/effect.h"
#include "effects/stages/detector.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition range_depth() {
  return {
      .name = "range_depth",
      .stage = Stage::detector,
      .kinds = kLandmarks | kRanges,
      .parameters = {{.name = "k",
                      .min = -3,
                      .max = 3,
                      .scale = 0.2,
                      .help = "Power of the cosine of the bearing; at 1 the range is the depth "
                              "along the detector's axis.",
                      .plausible = {-0.2, 1.2, "0 is a range, 1 a depth along the axis"}}},
      .help =
          "What is measured is the depth along the axis, or something between it and the "
          "distance: a size in the image gives the depth. Landmarks behind count by their "
          "depth backwards.",
      .formula = "range * abs(cos(bearing))^k",
      .signature = "ranges too short far from the axis, in proportion to range",
      .example = "range_depth: {k: 1}",
      .needs = {Need::distances},
      .advice = {{kLandmarks,
                  {},
                  "See landmarks at one distance straight ahead and far to the side."}},
      .detector =
          [](Values p, Detection& seen) {
            // At right angles there is no depth to speak of, and no power of it.
            constexpr double kLeastCosine = 1e-3;
            const double cosine = std::max(std::abs(maths::cos(seen.bearing_rad)), kLeastCosine);
            seen.range_m *= maths::pow(cosine, p[0]);
          },
      .proof = {{.values = {1},
                 .given = {{"range_m", 2}, {"bearing_rad", 0.5}},
                 .expected = {{"range_m", 1.75516512378075}, {"bearing_rad", 0.5}},
                 .source = "python: range_m * math.cos(bearing_rad), 0.5"},
                {.values = {-0.4},
                 .given = {{"range_m", 1.5}, {"bearing_rad", -2.4}},
                 .expected = {{"range_m", 1.69438261302523}},
                 .source = "python: range_m * abs(math.cos(bearing_rad)) ** p[0]"}},
  };
}

}  // namespace seam::effects
