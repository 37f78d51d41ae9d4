#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition frame_sync() {
  return {
      .name = "frame_sync",
      .stage = Stage::timing,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = {{.name = "period_frames",
                      .min = 0,
                      .max = 1000,
                      .scale = 1,
                      .help = "Frames in one cycle of the head; 0: the camera's own clock.",
                      .integer = true}},
      .help = "Frames are locked to the head's cycle instead of the camera's own clock.",
      .formula =
          "true time = c + round((stamp - c) n / T) T / n, T the cycle of the head, c its start",
      .signature = "the same head angles again and again",
      .example = "frame_sync: {period_frames: 25}",
      .timing = [](Values p,
                   Timing& timing) { timing.sync_period_frames = static_cast<int>(p[0]); },
  };
}

}  // namespace seam::effects
