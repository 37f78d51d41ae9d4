#include <algorithm>

#include "effects/stages/servo.h"

namespace seam::effects {

EffectDefinition speed_limit() {
  return {
      .name = "speed_limit",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 1e-3,
                      .max = 1e4,
                      .scale = 3,
                      .help = "Largest rate, radians per second.",
                      .fit_reciprocal = true}},
      .help = "The joint turns no faster than this.",
      .formula = "|dq/dt| <= limit",
      .signature = "ramps after steps; nothing while the command is slower than the limit",
      .example = "speed_limit: {rad_per_s: 3.0}",
      .term = Term::kinematic,
      .advice = {{kJoints,
                  {"acceleration_limit"},
                  "steps of different heights: the time of a ramp grows with the height, that of a "
                  "rounded one with its root"},
                 {kJoints, {}, "steps larger and faster than the joint can follow"}},
      .servo = [](Values p,
                  ServoModel& servo) { servo.rad_per_s = std::min(servo.rad_per_s, p[0]); },
      .proof = {{.values = {3},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.6}},
                 .source = "python: p[0] * at_s"},
                {.values = {1},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.15}},
                 .expected = {{"joint_rad", 0.15}},
                 .source = "python: p[0] * 0.1 + p[0] * 0.05"},
                {.values = {3},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.15}},
                 .expected = {{"joint_rad", 0.2}},
                 .source = "python: p[0] * 0.1 - 0.1"}},
  };
}

}  // namespace seam::effects
