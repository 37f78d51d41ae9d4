#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition wheel_slip() {
  return {
      .name = "wheel_slip",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "per_radps",
                      .min = 0,
                      .max = 1,
                      .scale = 0.02,
                      .help = "Share of the speed that is lost for each radian a second of turn.",
                      .plausible = {0, 0.5,
                                    "wheels that scrub lose up to a third in tight turns"}}},
      .help = "Wheels that roll round a turn slip: the body moves on less than they roll.",
      .formula = "v (1 - per_radps * abs(omega)), not below 0",
      .signature = "distance too short in turns, right on straight ways",
      .example = "wheel_slip: {per_radps: 0.05}",
      .needs = {Need::wheels, Need::turning, Need::path},
      .advice = {{kOdometry, {}, "arcs of several radii at several speeds, and straight drives"}},
      .locomotion = [](Values p, Locomotion& walk) { walk.wheels.slip_s += p[0]; },
      .proof =
          {{.values = {0.2},
            .given = {{"left_ticks", 900}, {"right_ticks", 1100}, {"for_s", 2}},
            .expected = {{"x_m", 0.757323886327107}, {"y_m", 0.413727924718674}, {"theta_rad", 1}},
            .source = "python: 0.9 * math.sin(1), 0.9 * (1 - math.cos(1)), 1"},
           {.values = {0.5},
            .given = {{"left_ticks", 500}, {"right_ticks", 500}, {"for_s", 1}},
            .expected = {{"x_m", 0.5}},
            .source = "python: 0.5"},
           {.values = {0.3},
            .given = {{"left_ticks", 1100}, {"right_ticks", 900}, {"for_s", 1}},
            .expected = {{"x_m", 0.589029689365527}, {"theta_rad", -1}},
            .source = "python: (1 - p[0]) * math.sin(1), -1"}},
  };
}

}  // namespace seam::effects
