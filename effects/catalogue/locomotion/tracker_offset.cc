#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition tracker_offset() {
  const auto offset = [](const char* name, const char* help) {
    return Parameter{.name = name,
                     .min = -2,
                     .max = 2,
                     .scale = 0.02,
                     .help = help,
                     .plausible = {-1, 1, "a mark on the body"}};
  };
  return {
      .name = "tracker_offset",
      .stage = Stage::locomotion,
      .kinds = kOdometry,
      .parameters = {offset("x_m", "Forward from the point about which the body turns, metres."),
                     offset("y_m", "To the left of it, metres.")},
      .help =
          "The measured pose is of a point beside the one about which the body turns: a marker or "
          "an antenna that is not above the middle of the axle (a lever arm).",
      .formula = "velocity of the point: vx - y_m omega, vy + x_m omega",
      .signature = "position errors that turn with the body: a circle in a turn on the spot",
      .example = "tracker_offset: {x_m: 0.08, y_m: 0.02}",
      .needs = {Need::turning},
      .advice = {{kOdometry,
                  {},
                  "Turn on the spot, several times round: the measured point then runs on a circle "
                  "whose radius is its distance from the middle of the axle."}},
      .tracker =
          [](Values p, Tracker& tracker) {
            tracker.x_m += p[0];
            tracker.y_m += p[1];
          },
      .proof =
          {{.values = {0.08, 0.02},
            .given = {{"vx_mps", 0.2}, {"omega_radps", 0.5}, {"for_s", 2}},
            .expected = {{"x_m", 0.282983158696046}, {"y_m", 0.242002802555102}, {"theta_rad", 1}},
            .source = "python: walked(p, [((0.2, 0, 0.5), 2)], beside)[0], walked(p, [((0.2, 0, "
                      "0.5), 2)], beside)[1], 1"},
           {.values = {-0.3, 0.1},
            .given = {{"omega_radps", -1}, {"for_s", 1.5}},
            .expected = {{"x_m", 0.378528338160095}, {"y_m", 0.206322216147987}},
            .source = "python: -p[0] + p[0] * math.cos(1.5) + p[1] * math.sin(1.5), -p[1] - p[0] * "
                      "math.sin(1.5) + p[1] * math.cos(1.5)"}},
  };
}

}  // namespace seam::effects
