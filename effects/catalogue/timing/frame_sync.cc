#include "effects/effect.h"
#include "effects/stages/timing.h"

namespace seam::effects {

EffectDefinition frame_sync() {
  std::vector<std::vector<double>> counts;
  for (int frames = 2; frames <= 100; ++frames) counts.push_back({static_cast<double>(frames)});
  return {
      .name = "frame_sync",
      .stage = Stage::timing,
      .kinds = kPoints | kRanges,
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
      .needs = {Need::repeating_motion},
      .starts = {{kPoints, StartSearch::listed, counts}},
      .timing = [](Values p,
                   Timing& timing) { timing.sync_period_frames = static_cast<int>(p[0]); },
      .proof = {{.values = {25},
                 .given = {{"stamp_s", 1.03}, {"cycle_s", 2}},
                 .expected = {{"start_s", 1.04}},
                 .source = "python: 13 * 2 / 25"},
                {.values = {4},
                 .given = {{"stamp_s", 0.6}, {"cycle_s", 1}},
                 .expected = {{"start_s", 0.5}},
                 .source = "python: 2 * 1 / 4"}},
  };
}

}  // namespace seam::effects
