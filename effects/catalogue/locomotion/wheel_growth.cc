#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

// The first term in the speed of a wheel's effective radius: tyres grow with their speed (Pacejka,
// Tyre and Vehicle Dynamics, 3rd edition, section 4.3.1), and driven wheels slip the more the more
// resistance the speed brings. Below 0.05 for each m/s in what was seen of small robots.
EffectDefinition wheel_growth() {
  return {
      .name = "wheel_growth",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "per_mps",
                      .min = -0.5,
                      .max = 0.5,
                      .scale = 0.02,
                      .help =
                          "Share by which a wheel's radius is larger for each m/s of its speed; "
                          "negative: smaller.",
                      .plausible = {-0.1, 0.1, "tyres grow by less than 1 % at 10 m/s"}}},
      .help = "A wheel's radius depends on its speed: both wheels alike, each by its own speed.",
      .formula = "wheel (1 + per_mps |wheel|), wheel its speed in m/s",
      .signature =
          "distance error that grows with the square of the speed; turns are short or long "
          "at speed alone",
      .example = "wheel_growth: {per_mps: 0.03}",
      .needs = {Need::wheels, Need::path},
      .advice = {{kOdometry,
                  {"wheel_scale"},
                  "Drive the same way slowly and fast: a wrong size of the wheels errs alike."},
                 {kOdometry, {}, "the same straight drive at several speeds"}},
      .locomotion = [](Values p, Locomotion& walk) { walk.wheels.growth_s_per_m += p[0]; },
      .proof = {{.values = {0.5},
                 .given = {{"left_ticks", 500}, {"right_ticks", 500}, {"for_s", 2}},
                 .expected = {{"x_m", 0.5625}, {"theta_rad", 0}},
                 .source = "python: 0.5 * (1 + p[0] * 0.25), 0"},
                {.values = {-0.2},
                 .given = {{"left_ticks", 900}, {"right_ticks", 1100}, {"for_s", 2}},
                 .expected = {{"x_m", 0.806128907149214},
                              {"y_m", 0.340825835370388},
                              {"theta_rad", 0.799999999992432}},
                 .source = "python: rolled([((0.45, 0.55), 2)], *[lambda w, v, omega: w * (1 + "
                           "p[0] * abs(w))] * 2)[0], rolled([((0.45, 0.55), 2)], *[lambda w, v, "
                           "omega: w * (1 + p[0] * abs(w))] * 2)[1], rolled([((0.45, 0.55), 2)], "
                           "*[lambda w, v, omega: w * (1 + p[0] * abs(w))] * 2)[2]"}},
  };
}

}  // namespace seam::effects
