#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

EffectDefinition differential_drive() {
  return {
      .name = "differential_drive",
      .stage = Stage::locomotion,
      .kinds = kOdometry | kRanges,
      .parameters = {{.name = "metres_per_tick",
                      .min = 1e-9,
                      .max = 1,
                      .scale = 1e-4,
                      .help = "Path of a wheel for each tick of its encoder, metres.",
                      .required = true},
                     {.name = "base_m",
                      .min = 0.01,
                      .max = 10,
                      .scale = 0.2,
                      .help = "Distance between the wheels' points of contact, metres.",
                      .required = true}},
      .help =
          "A body on two wheels moves as their ticks say, or drives its wheels as velocities "
          "command them; it never moves sideways. The base to which effects of wheels are "
          "added.",
      .formula =
          "v = (left + right) / 2, omega = (right - left) / base_m, left and right the "
          "wheels' speeds: metres_per_tick * ticks / time",
      .signature = "none: it is the base of models of wheels",
      .example = "differential_drive: {metres_per_tick: 9.4e-05, base_m: 0.2}",
      .has_neutral = false,
      .base = Base::wheels,
      .replaces_base = Base::walk,
      .needs = {Need::wheels},
      .locomotion =
          [](Values p, Locomotion& walk) {
            walk.wheels.driven = true;
            walk.wheels.metres_per_tick = p[0];
            walk.wheels.base_m = p[1];
          },
      .proof =
          {{.values = {0.001, 0.2},
            .given = {{"left_ticks", 900}, {"right_ticks", 1100}, {"for_s", 2}},
            .expected = {{"x_m", 0.841470984807897}, {"y_m", 0.45969769413186}, {"theta_rad", 1}},
            .source = "python: math.sin(1), 1 - math.cos(1), 1"},
           {.values = {0.002, 0.5},
            .given = {{"left_ticks", -100}, {"right_ticks", 100}, {"for_s", 1}},
            .expected = {{"x_m", 0}, {"theta_rad", 0.8}},
            .source = "python: 0, 200 * p[0] / p[1]"}},
  };
}

}  // namespace seam::effects
