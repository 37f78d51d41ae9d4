#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

// One transaction on a serial line or a bus takes 0.1 to 10 ms, by which the second count is later
// than the first.
EffectDefinition encoder_skew() {
  return {
      .name = "encoder_skew",
      .stage = Stage::locomotion,
      .kinds = kOdometry,
      .parameters = {{.name = "right_late_s",
                      .min = -0.2,
                      .max = 0.2,
                      .scale = 2e-3,
                      .help = "How long after the left wheel's count that of the right wheel is "
                              "read, seconds; the row's time is the left one's.",
                      .plausible = {-0.1, 0.1,
                                    "counters are read within one period of a controller"}}},
      .help =
          "The encoders of the two wheels are read one after the other, and both counts get one "
          "time.",
      .formula = "right ticks are counted until t + right_late_s, left ticks until t",
      .signature = "heading error in proportion to the speed, gone when the body stands",
      .example = "encoder_skew: {right_late_s: 0.004}",
      .needs = {Need::wheels, Need::path},
      .advice = {{kOdometry,
                  {"frame_latency"},
                  "Drive straight at changing speed: a late pose is as late in its heading, which "
                  "does not change there."},
                 {kOdometry,
                  {},
                  "Start and stop on straight ways, several times, and measure often: the heading "
                  "seems to turn when the speed changes, and turns back."}},
      .tracker = [](Values p, Tracker& tracker) { tracker.right_late_s += p[0]; },
      .proof = {{.values = {0.1},
                 .given = {{"left_ticks", 100},
                           {"right_ticks", 100},
                           {"for_s", 1},
                           {"left_ticks", 200},
                           {"right_ticks", 200},
                           {"for_s", 1}},
                 .expected = {{"theta_rad", -0.0999999999999998}},
                 .source =
                     "python: (0.1 * (1 - p[0]) + 0.2 * (1 - p[0]) + 0.1 * p[0] - 0.3) / 0.2"},
                {.values = {-0.2},
                 .given = {{"left_ticks", 0}, {"right_ticks", 100}, {"for_s", 1}},
                 .expected = {{"theta_rad", 0.5}},
                 .source = "python: 0.1 / 0.2"}},
  };
}

}  // namespace seam::effects
