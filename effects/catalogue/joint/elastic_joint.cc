#include "effects/stages/servo.h"

namespace seam::effects {

// Spong, Modeling and control of elastic joint robots, Journal of Dynamic Systems 109, 1987; the
// damper as in De Luca and Book, Robots with flexible elements (Springer Handbook of Robotics).
// What the load does to the drive is left out. Plausible: joints of arms and heads swing at 2 to 30
// Hz, damped by 0.01 to 0.3.
EffectDefinition elastic_joint() {
  return {
      .name = "elastic_joint",
      .stage = Stage::joint,
      .kinds = kJoints,
      .parameters = {{.name = "period_s",
                      .min = 0,
                      .max = 2,
                      .scale = 0.1,
                      .help = "In which the load swings to and fro on the drive that holds still, "
                              "seconds (0.125: 8 Hz); 0: stiff.",
                      .plausible = {0, 1, "joints of arms and heads swing at 2 to 30 Hz"}},
                     {.name = "damping",
                      .min = 0,
                      .max = 0.95,
                      .scale = 0.1,
                      .help = "Share of the damping at which the load no longer swings.",
                      .plausible = {0, 0.6, "gears and links 0.01 to 0.3, rubber up to 0.5"}}},
      .help =
          "The load hangs on the drive by a spring and a damper: gears, a belt or a link that "
          "bend. Two masses, of which the load does not move the drive.",
      .formula =
          "d2q/dt2 = w^2 (m - q) + 2 damping w (dm/dt - dq/dt), w = 2 pi / period, m the drive",
      .signature = "swings of one period after starts and stops, whatever the gain",
      .example = "elastic_joint: {period_s: 0.12, damping: 0.1}",
      .needs = {Need::moving_joint},
      .starts = {{kJoints, StartSearch::frequency}},
      .advice = {{kJoints,
                  {"motor_servo", "acceleration_limit"},
                  "the same steps at two gains: a controller's swing changes its period with the "
                  "gain, that of an elastic joint does not"},
                 {kJoints, {}, "steps that end, with several rows in each swing"}},
      .servo = [](Values p,
                  ServoModel& servo) { servo.elastic = {.period_s = p[0], .damping = p[1]}; },
      .proof =
          {{.values = {0.25, 0.2},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}},
            .expected = {{"joint_rad", 1.54827076150994}},
            .source = "python: 1 - math.exp(-p[1] * 8 * math.pi * at_s) * (math.cos(8 * math.pi * "
                      "math.sqrt(1 - p[1]**2) * at_s) - p[1] / math.sqrt(1 - p[1]**2) * math.sin(8 "
                      "* math.pi * math.sqrt(1 - p[1]**2) * at_s))"},
           {.values = {0.1, 0.05},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"limit_radps", 2}, {"at_s", 0.17}},
            .expected = {{"joint_rad", 0.357689998066416}},
            .source = "python: elastic(p, lambda t: 2 * t, lambda t: 2, at_s)",
            .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
