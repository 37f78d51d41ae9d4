#include "effects/effect.h"
#include "effects/stages/sensor/sensor.h"

namespace seam::effects {

EffectDefinition response_cubic() {
  return {
      .name = "response_cubic",
      .stage = Stage::sensor,
      .kinds = kPhotometry | kFrames | kRanges,
      // Wide bounds: full scale is that of the file, of which 12 bits right-aligned in 16 fill a
      // sixteenth.
      .parameters =
          {{.name = "k2",
            .min = -50,
            .max = 50,
            .scale = 0.05,
            .help = "Bend at full scale, relative to the signal."},
           {.name = "k3", .min = -1000, .max = 1000, .scale = 0.05, .help = "Its cubic part."}},
      .help = "The response to light bends a little, as amplifiers' do.",
      .formula = "signal * (1 + k2 s + k3 s^2), s = signal / full scale (2^bits - 1)",
      .signature = "a curved mean against illumination, straight near the dark",
      .example = "response_cubic: {k2: -0.02, k3: 0.004}",
      .family = Family::brightness,
      .advice =
          {{kPhotometry,
            {},
            "Levels in even steps from a hundredth of full scale to nearly full separate one bend "
            "of the response from another."}},
      .sensor = [](Values p, SensorChain& chain) { chain.cubic2 = p[0], chain.cubic3 = p[1]; },
      .proof = {{.values = {-0.1, 0.05},
                 .given = {{"light", 0.51}},
                 .expected = {{"mean_dn", 106.736}},
                 .source = "python: 102 * (1 + p[0] * 0.4 + p[1] * 0.16) + 8"},
                {.values = {0.2, 0},
                 .given = {{"light", 1.275}},
                 .expected = {{"mean_dn", 314}},
                 .source = "python: 255 * (1 + p[0]) + 8"}},
  };
}

}  // namespace seam::effects
