#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition periodic_pattern() {
  return {
      .name = "periodic_pattern",
      .stage = Stage::sensor,
      .kinds = kPhotometry,
      .parameters = {{.name = "amplitude_dn",
                      .min = 0,
                      .max = 60000,
                      .scale = 1,
                      .help = "Of the wave, DN.",
                      .plausible = {0, 6000, "a tenth of 16 bits is a picture and no disturbance"}},
                     {.name = "period_px",
                      .neutral = 8,
                      .min = 2,
                      .max = 2000,
                      .scale = 0.1,
                      .help = "From crest to crest, pixels."},
                     {.name = "angle_rad",
                      .min = -1.6,
                      .max = 1.6,
                      .scale = 0.01,
                      .help =
                          "Direction in which it advances, from the rows' direction towards down."},
                     {.name = "phase_rad",
                      .min = -7,
                      .max = 7,
                      .scale = 0.1,
                      .help = "Of the sine at the top-left pixel."}},
      .help = "A fixed wave over the image, as clocks and power supplies leave it.",
      .formula = "dn + amplitude sin(2 pi (u cos(angle) + v sin(angle)) / period + phase)",
      .signature = "stripes of one period that stay, also in the dark",
      .example = "periodic_pattern: {amplitude_dn: 2, period_px: 8, angle_rad: 0.3, phase_rad: 1}",
      .needs = {Need::repeated_pixels},
      .starts = {{kPhotometry, StartSearch::frequency}},
      .advice =
          {{kPhotometry,
            {"column_offsets"},
            "More frames at one brightness, in the dark, too: their mean shows whether columns "
            "follow a wave or each has a value of its own."},
           {kPhotometry,
            {"lamp_flicker"},
            "Dark frames: a pattern of the camera is there, too, and at the same place in "
            "each; flicker is in light alone and moves from frame to frame."},
           {kPhotometry, {}, "Many frames of one brightness, in the dark, too."}},
      .sensor =
          [](Values p, SensorChain& chain) {
            chain.wave = {
                .amplitude_dn = p[0], .period_px = p[1], .angle_rad = p[2], .phase_rad = p[3]};
          },
      .proof = {{.values = {2, 8, 0, 0.5},
                 .given = {{"u_px", 3}, {"v_px", 11}},
                 .expected = {{"wave_dn", 0.563079062285402}},
                 .source = "python: p[0] * math.sin(2 * math.pi * u_px / p[1] + p[3])"},
                {.values = {3, 25, 1, -2},
                 .given = {{"u_px", 100}, {"v_px", 7}},
                 .expected = {{"wave_dn", 1.42060637795757}},
                 .source = "python: p[0] * math.sin(2 * math.pi * (u_px * math.cos(p[2]) + v_px * "
                           "math.sin(p[2])) / p[1] + p[3])"}},
  };
}

}  // namespace seam::effects
