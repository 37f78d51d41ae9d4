#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

// Drivers stamp a frame at the start, in the middle or at the end of its exposure (or when it is
// read, which is after the end): GenICam's SFNC has the events ExposureStart, ExposureEnd and
// FrameStart. With automatic exposure the offset follows the light. Plausible: -0.5, 0, 0.5.
EffectDefinition exposure_stamp() {
  return {
      .name = "exposure_stamp",
      .stage = Stage::timing,
      .kinds = kPoints,
      .parameters = {{.name = "per_exposure",
                      .min = -2,
                      .max = 2,
                      .scale = 0.5,
                      .help = "True time of a frame minus its stamp, in units of its own exposure: "
                              "0.5 where stamps are the starts, 0 the middles, -0.5 the ends.",
                      .plausible = {-1, 1, "stamps are starts, middles or ends: -0.5 to 0.5"}}},
      .help =
          "Stamps are not of the middle of the exposure, so that the latency changes with the "
          "exposure of the frame (column exposure_s).",
      .formula = "true time = stamp + per_exposure * exposure_s of the frame",
      .signature = "displacement with rate times the frame's exposure",
      .example = "exposure_stamp: {per_exposure: 0.5}",
      .columns = {"exposure_s"},
      .needs = {Need::known_pose},
      .advice = {{kPoints,
                  {"frame_latency", "exposure"},
                  "Move in bright and in dim light: only what belongs to the exposure changes with "
                  "it."},
                 {kPoints, {}, "fast motion at short and at long exposures"}},
      .timing = [](Values p, Timing& timing) { timing.per_exposure += p[0]; },
      .proof = {{.values = {0.5},
                 .given = {{"stamp_s", 4}, {"frame_exposure_s", 0.008}},
                 .expected = {{"start_s", 4.004}},
                 .source = "python: 4.004"},
                {.values = {-0.5},
                 .given = {{"stamp_s", 1}, {"row", 30}, {"frame_exposure_s", 0.02}},
                 .expected = {{"middle_s", 0.99}},
                 .source = "python: 0.99"}},
  };
}

}  // namespace seam::effects
