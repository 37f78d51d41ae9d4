#include "effects/stages/servo.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition gravity_torque() {
  return {
      .name = "gravity_torque",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "rad_per_s2",
                      .min = -1e5,
                      .max = 1e5,
                      .scale = 10,
                      .help = "Angular acceleration by gravity where the load is level, rad/s^2, "
                              "towards smaller angles: weight times lever over inertia."},
                     {.name = "level_rad",
                      .min = -2 * maths::kPi,
                      .max = 2 * maths::kPi,
                      .scale = 0.3,
                      .help = "The angle at which the load is level, radians (pi / 2 where angle 0 "
                              "hangs down)."}},
      .help =
          "A load that is not balanced: gravity turns the joint, and swings it where nothing "
          "drives it.",
      .formula = "load = rad_per_s2 * cos(q - level), in dw/dt of motor_servo",
      .signature = "error that depends on the angle, larger at low gains; a swing without torque",
      .example = "gravity_torque: {rad_per_s2: 60, level_rad: 1.57}",
      .needs_base = Base::motor,
      .shows_at_rest = true,
      .starts = {{kJoints, StartSearch::motion, {{10, 0}, {10, 1.5}}}},
      .advice =
          {{kJoints,
            {"encoder_offset"},
            "two gains: an offset is the same at each, the way that a load hangs is not"},
           {kJoints,
            {},
            "free swings (torque_enable 0), or slow moves over the whole range at two gains"}},
      .servo =
          [](Values p, ServoModel& servo) {
            servo.torque.gravity_rad_per_s2 = p[0];
            servo.torque.level_rad = p[1];
          },
      // A load that hangs the other way round at the opposite level is the same load: reported as a
      // positive one, its level within half a turn.
      .told_once =
          [](std::vector<double>& values) {
            if (values[0] < 0) values[0] = -values[0], values[1] += maths::kPi;
            values[1] = maths::wrap_angle(values[1]);
          },
      .proof = {{.values = {60, 0},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.345522685275671}},
                 .source = "python: swung(at_s, gravity=p[0])",
                 .tolerance = 1e-07},
                {.values = {90, 1.2},
                 .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.3}},
                 .expected = {{"joint_rad", 0.478489050125883}},
                 .source = "python: swung(at_s, gravity=p[0], level=p[1])",
                 .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
