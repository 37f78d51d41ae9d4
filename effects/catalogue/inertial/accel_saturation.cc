#include "effects/stages/inertial/inertial.h"

namespace seam::effects {

EffectDefinition accel_saturation() {
  return {
      .name = "accel_saturation",
      .stage = kInertial,
      .kinds = kImu,
      .parameters = {{.name = "most_mps2",
                      .neutral = kNever,
                      .min = 1e-3,
                      .max = kNever,
                      .scale = 50,
                      .help = "The end of its range, m/s^2.",
                      .fit_reciprocal = true}},
      .help = "The accelerometer reports no more than this.",
      .formula = "clipped to -most .. most",
      .signature = "a mean that stays behind at the largest values",
      .example = "accel_saturation: {most_mps2: 40}",
      .starts = {{kImu, StartSearch::ceiling}},
      .noise = [](Values p, Noise& errors) { errors.inertial.accel.most = p[0]; },
      .proof = {{.values = {2},
                 .given = {{"ax_mps2", 1}, {"ay_mps2", 5}, {"az_mps2", -6}},
                 .expected = {{"ax_mps2", 1}, {"ay_mps2", 2}, {"az_mps2", -2}},
                 .source = "python: 1, p[0], -p[0]"},
                {.values = {7.5},
                 .given = {{"ax_mps2", 8}, {"ay_mps2", -9}, {"az_mps2", 3}},
                 .expected = {{"ax_mps2", 7.5}, {"ay_mps2", -7.5}, {"az_mps2", 3}},
                 .source = "python: p[0], -p[0], 3"}},
  };
}

}  // namespace seam::effects
