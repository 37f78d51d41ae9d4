#include "effects/effect.h"
#include "effects/stages/joint_track.h"

namespace seam::effects {

EffectDefinition encoder_quantisation() {
  return {
      .name = "encoder_quantisation",
      .stage = Stage::joint,
      .kinds = kPoints | kJoints,
      .parameters = {{.name = "step_rad",
                      .min = 0,
                      .max = 0.2,
                      .scale = 0.005,
                      .help = "Step of the logged angle, radians.",
                      .plausible = {0, 0.03, "8 bits over a turn: 0.025"}}},
      .help = "The logged angle is rounded to steps.",
      .formula = "logged = round(true / step) * step; in points a spread of step / sqrt(12)",
      .signature = "saw-tooth against the angle",
      .example = "encoder_quantisation: {step_rad: 0.003}",
      .spread_only = true,
      .needs = {Need::encoder_steps},
      .encoder = [](Values p, JointTrack& track) { track.quantisation_step_rad = p[0]; },
      .proof = {{.values = {0.003},
                 .expected = {{"rounding_sigma_rad", 0.000866025403784439}},
                 .source = "python: p[0] / math.sqrt(12)"},
                {.values = {0.02},
                 .expected = {{"rounding_sigma_rad", 0.00577350269189626}},
                 .source = "python: p[0] / math.sqrt(12)"}},
  };
}

}  // namespace seam::effects
