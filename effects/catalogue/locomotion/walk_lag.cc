#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition walk_lag() {
  return {
      .name = "walk_lag",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "tau_s",
                      .min = 0,
                      .max = 10,
                      .scale = 0.1,
                      .help = "Time constant with which the velocity follows its command, seconds.",
                      .plausible = {0, 2, "bodies follow within a step or two"}}},
      .help =
          "The body has mass and the gait a period: all three velocities start at rest and "
          "follow their commands with a lag.",
      .formula = "dv/dt = (command - v) / tau",
      .signature = "error after each change of command",
      .example = "walk_lag: {tau_s: 0.2}",
      .needs = {Need::commanded_walk},
      .starts = {{kOdometry, StartSearch::listed, {{0.02}, {0.2}, {1.0}}}},
      .advice = {{kOdometry,
                  {"odometry_scale", "heading_drift", "walk_noise"},
                  "many changes of command within a run"},
                 {kOdometry, {}, "many changes of command within a run"}},
      .locomotion = [](Values p, Locomotion& walk) { walk.tau_s += p[0]; },
      .proof = {{.values = {0.2},
                 .given = {{"vx_mps", 0.3}, {"for_s", 1}},
                 .expected = {{"x_m", 0.240404276819945}},
                 .source = "python: 0.3 * (1 - p[0] * (1 - math.exp(-1 / p[0])))",
                 .tolerance = 4e-05},
                {.values = {0.2},
                 .given = {{"vx_mps", 0.3}, {"for_s", 0.5}, {"vx_mps", 0}, {"for_s", 0.5}},
                 .expected = {{"x_m", 0.145479176902511}},
                 .source = "python: 0.3 * (0.5 - p[0] * (1 - math.exp(-2.5))) + 0.3 * (1 - "
                           "math.exp(-2.5)) * p[0] * (1 - math.exp(-2.5))",
                 .tolerance = 4e-05}},
  };
}

}  // namespace seam::effects
