#include "effects/effect.h"
#include "effects/stages/optics.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition lamp_flicker() {
  return {
      .name = "lamp_flicker",
      .stage = Stage::light,
      .kinds = kPhotometry | kFrames | kRanges,
      .parameters = {{.name = "frequency_hz",
                      .min = 0,
                      .max = 5000,
                      .scale = 100,
                      .help = "Frequency of the light, hertz.",
                      .plausible = {20, 5000,
                                    "twice the mains: 100 and 120 Hz, railways 33; dimmers to "
                                    "some kHz"}},
                     {.name = "depth",
                      .min = 0,
                      .max = 1,
                      .scale = 0.05,
                      .help = "Amplitude relative to the mean."},
                     {.name = "phase_rad",
                      .min = -7,
                      .max = 7,
                      .scale = 1,
                      .help = "Phase at the set's time 0, radians."}},
      .help = "Lamps on alternating current; each row integrates the light over its own window.",
      .formula = "light = 1 + depth sin(2 pi f t + phase), integrated over the window",
      .signature =
          "a wave along rows, in proportion to intensity; stands still when the frame period holds "
          "whole cycles",
      .example = "lamp_flicker: {frequency_hz: 100, depth: 0.1, phase_rad: 0.3}",
      .needs = {Need::light, Need::frame_times},
      .starts = {{kPhotometry | kFrames, StartSearch::frequency}},
      .light =
          [](Values p, const LightWindow& window) {
            // The mean of the sine over the window is the sine at its middle times a sinc.
            const double depth = p[1] * sinc(maths::kPi * p[0] * window.exposure_s);
            return 1 + depth * maths::sin(2 * maths::kPi * p[0] * window.middle_s() + p[2]);
          },
      .proof = {{.values = {100, 0.1, 0.3},
                 .given = {{"start_s", 0.123}},
                 .expected = {{"lamp", 1.08172582271979}},
                 .source = "python: 1 + p[1] * math.sin(2 * math.pi * p[0] * start_s + p[2])"},
                {.values = {100, 0.2, -1},
                 .given = {{"start_s", 0.004}, {"exposure_s", 0.003}},
                 .expected = {{"lamp", 1.10872824270326}},
                 .source = "python: 1 + p[1] * (math.cos(0.8 * math.pi + p[2]) - math.cos(1.4 * "
                           "math.pi + p[2])) / (0.6 * math.pi)"}},
  };
}

}  // namespace seam::effects
