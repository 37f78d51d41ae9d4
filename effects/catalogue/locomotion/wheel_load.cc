#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

// A tyre's effective radius falls with its load (Pacejka, Tyre and Vehicle Dynamics, 3rd edition,
// section 4.3.1), and in a turn acceleration to the side, height of mass over track times it, moves
// load from the inner to the outer wheel. Hard wheels of small robots have less than 0.01, soft
// ones up to 0.1 s^2/m.
EffectDefinition wheel_load() {
  return {
      .name = "wheel_load",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "per_mps2",
                      .min = -1,
                      .max = 1,
                      .scale = 0.02,
                      .help = "Share by which the outer wheel's radius is smaller, and the inner "
                              "one's larger, for each m/s^2 of acceleration to the side.",
                      .plausible = {-0.1, 0.1, "tyres give by less than 2 % at 1 m/s^2"}}},
      .help =
          "A wheel's radius depends on its load: in turns the outer wheel carries more and rolls "
          "less far.",
      .formula = "left (1 + per_mps2 v omega), right (1 - per_mps2 v omega)",
      .signature = "fast turns too short, slow ones right; straight ways right",
      .example = "wheel_load: {per_mps2: 0.05}",
      .needs = {Need::wheels, Need::turning, Need::path},
      .advice = {{kOdometry,
                  {"base_scale"},
                  "Drive the same circle slowly and fast: a wrong base turns it alike."},
                 {kOdometry, {}, "the same circles, both ways round, at several speeds"}},
      .locomotion = [](Values p, Locomotion& walk) { walk.wheels.inner_s2_per_m += p[0]; },
      .proof =
          {{.values = {0.1},
            .given = {{"left_ticks", 900}, {"right_ticks", 1100}, {"for_s", 2}},
            .expected = {{"x_m", 0.906579550830919},
                         {"y_m", 0.356853804398164},
                         {"theta_rad", 0.750000000004002}},
            .source =
                "python: rolled([((0.45, 0.55), 2)], lambda w, v, omega: w * (1 + p[0] * v * "
                "omega), lambda w, v, omega: w * (1 - p[0] * v * omega))[0], rolled([((0.45, "
                "0.55), 2)], lambda w, v, omega: w * (1 + p[0] * v * omega), lambda w, v, omega: w "
                "* (1 - p[0] * v * omega))[1], rolled([((0.45, 0.55), 2)], lambda w, v, omega: w * "
                "(1 + p[0] * v * omega), lambda w, v, omega: w * (1 - p[0] * v * omega))[2]"},
           {.values = {0.4},
            .given = {{"left_ticks", 550}, {"right_ticks", 450}, {"for_s", 1}},
            .expected = {{"theta_rad", 0}},
            .source = "python: (0.45 * (1 + p[0] * 0.25) - 0.55 * (1 - p[0] * 0.25)) / 0.2"}},
  };
}

}  // namespace seam::effects
