#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition frame_latency() {
  return {
      .name = "frame_latency",
      .stage = Stage::timing,
      .kinds = kPoints | kOdometry | kLandmarks | kRanges | kFrames,
      .parameters = {{.name = "latency_s",
                      .min = -0.2,
                      .max = 0.2,
                      .scale = 5e-3,
                      .help = "True time of a frame, or of a measured pose, minus its stamp, "
                              "seconds."}},
      .help =
          "The stamp of a frame, or of what a motion capture measures, is early or late by a "
          "constant.",
      .formula = "true time = stamp + latency",
      .signature = "displacement with rate, equal in all rows",
      .example = "frame_latency: {latency_s: 0.012}",
      .advice = {{kPoints,
                  {"exposure"},
                  "Expose for two different known times: only the window's length moves with the "
                  "exposure."},
                 {kOdometry,
                  {"walk_lag"},
                  "Change the command by steps, and measure often after each: a lag fades in, a "
                  "latency shifts."},
                 {kOdometry, {}, "starts, stops and turns within a run"}},
      .timing = [](Values p, Timing& timing) { timing.latency_s += p[0]; },
      .proof = {{.values = {0.012},
                 .given = {{"stamp_s", 3}},
                 .expected = {{"start_s", 3.012}},
                 .source = "python: stamp_s + p[0]"},
                {.values = {-0.004},
                 .given = {{"stamp_s", 0.5}, {"row", 20}},
                 .expected = {{"end_s", 0.496}},
                 .source = "python: stamp_s + p[0]"}},
  };
}

}  // namespace seam::effects
