#include "effects/effect.h"
#include "effects/stages/geometry.h"

namespace seam::effects {

// A lens grows and bends light less as it warms: by a - (dn/dT) / (n - 1) of its focal length for
// each kelvin, a its expansion, n its index. Acrylic: 7e-5 + 1.05e-4 / 0.49 = 2.8e-4;
// polycarbonate 2.5e-4; germanium -1.3e-4; common glass 1e-6 to 1e-5. The housing adds its own
// expansion, 2.3e-5 in aluminium and 7e-5 in plastic. The reference is a temperature that the model
// states and not the set's mean, so that a model serves other sets.
EffectDefinition focal_temperature() {
  return {
      .name = "focal_temperature",
      .stage = Stage::geometry,
      .kinds = kPoints,
      .parameters = {{.name = "per_k",
                      .min = -0.01,
                      .max = 0.01,
                      .scale = 1e-4,
                      .help = "Growth of the focal length for each kelvin of the column "
                              "temperature_c, as a share. Glass in metal: 1e-5 to 3e-5, plastic "
                              "lenses: up to 3e-4.",
                      .plausible = {-5e-4, 5e-4,
                                    "acrylic lenses 2.8e-4, with a housing of plastic 3.5e-4; "
                                    "glass and metal 1e-5 to 1e-4; germanium -1.3e-4"}},
                     {.name = "at_c",
                      .neutral = kFocalAt_c,
                      .min = -273.15,
                      .max = 1000,
                      .scale = 10,
                      .help = "The temperature at which the focal length is that of the base, "
                              "degrees Celsius. That length has its smallest error at the middle "
                              "of a set's temperatures.",
                      .stated = true,
                      .plausible = {-60, 150, "cameras of cars and aircraft work at -40 to 105"}}},
      .help =
          "The focal length follows the temperature, which the set has in a column temperature_c.",
      .formula = "f (1 + per_k (temperature_c - at_c))",
      .signature = "radial from the principal point, growing with temperature_c",
      .example = "focal_temperature: {per_k: 0.0001}",
      .columns = {"temperature_c"},
      .advice = {{kPoints,
                  {"focal_drift", "focus_variation"},
                  "Let the camera cool down again, or take its temperatures out of order: a drift "
                  "goes on with time, an autofocus follows the scene, only the temperature comes "
                  "back."},
                 {kPoints, {}, "the same scene at far temperatures, warm and cold in turns"},
                 {kOutcomes,
                  {},
                  "a scenario has no temperatures: state the focal length that the camera has at "
                  "the temperature meant"}},
      .geometry =
          [](Values p, ImagePoint& point) {
            const double factor = 1 + p[0] * (point.columns.value("temperature_c", p[1]) - p[1]);
            point.fx *= factor, point.fy *= factor;
          },
      .proof = {{.values = {0.0001, 20},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}, {"temperature_c", 50}},
                 .expected = {{"u_px", 127.0152}, {"v_px", 45.50224}},
                 .source = "python: 160 * 1.003 * 0.24 + 88.5, 162 * 1.003 * -0.16 + 71.5"},
                {.values = {-0.0003, 45},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}, {"temperature_c", -15}},
                 .expected = {{"u_px", -9.22800000000001}, {"v_px", 137.4664}},
                 .source = "python: 160 * -0.6 * 1.018 + 88.5, 162 * 0.4 * 1.018 + 71.5"}},
  };
}

}  // namespace seam::effects
