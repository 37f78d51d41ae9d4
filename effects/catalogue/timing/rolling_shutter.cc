#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition rolling_shutter() {
  return {
      .name = "rolling_shutter",
      .stage = Stage::timing,
      .kinds = kPoints | kPhotometry | kRanges | kFrames,
      .parameters = {{.name = "line_delay_s",
                      .min = -1e-2,
                      .max = 1e-2,
                      .scale = 1e-4,
                      .help = "Time from one row's exposure to the next row's, seconds; negative: "
                              "the last row is exposed first.",
                      .plausible = {-0.0005, 0.0005,
                                    "rows of common sensors follow each other after 5 to 80 us, of "
                                    "the ERS-210 after about 280"}}},
      .help =
          "The rows of a CMOS imager are exposed one after the other (section 4.5 of the "
          "founding paper), so whatever moves is sheared.",
      .formula = "row v is exposed from stamp + line_delay * v",
      .signature = "displacement grows with row x rate of the camera or the object",
      .example = "rolling_shutter: {line_delay_s: 2.78e-4}",
      .advice = {{kPoints,
                  {"frame_latency"},
                  "Swing faster with points over all rows: a line delay grows with the row, a "
                  "latency does not."}},
      .timing = [](Values p, Timing& timing) { timing.line_delay_s += p[0]; },
      .proof = {{.values = {0.0002},
                 .given = {{"stamp_s", 12.5}, {"row", 71}},
                 .expected = {{"start_s", 12.5142}},
                 .source = "python: stamp_s + p[0] * row"},
                {.values = {-0.0003},
                 .given = {{"stamp_s", 0}, {"row", 100}},
                 .expected = {{"middle_s", -0.03}},
                 .source = "python: p[0] * row"}},
  };
}

}  // namespace seam::effects
