#include <cmath>

#include "effects/stages/servo.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

EffectDefinition gravity_sag() {
  return {
      .name = "gravity_sag",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters =
          {{.name = "rad",
            .min = -1,
            .max = 1,
            .scale = 0.01,
            .help = "How far the load hangs where it is level, radians (positive: towards "
                    "smaller angles).",
            .plausible =
                {-0.3, 0.3,
                 "a servo whose controller has no integral part hangs by up to 10 degrees"}},
           {.name = "level_rad",
            .min = -maths::kPi,
            .max = maths::kPi,
            .scale = 0.3,
            .help = "The angle at which the load is level, radians.",
            .on_demand = true}},
      .help = "A load that is not balanced bends the drive by its torque.",
      .formula = "q - sag * cos(q - level)",
      .signature = "error that depends on the angle, not on the rate",
      .example = "gravity_sag: {rad: 0.02}",
      .term = Term::kinematic,
      .family = Family::pointing,
      .shows_at_rest = true,
      .advice = {{kJoints,
                  {"encoder_offset"},
                  "a wide range of angles: an offset is the same at each"},
                 {kJoints, {}, "slow moves over the whole range of angles"}},
      .servo =
          [](Values p, ServoModel& servo) {
            servo.sag_rad += p[0];
            servo.level_rad += p[1];
          },
      // A load that hangs the other way round at the opposite level is the same load. Shown with
      // the level within a right angle of zero, as far as data constrain a right angle; there with
      // a positive sag.
      .told_once =
          [](std::vector<double>& values) {
            constexpr double kMargin_rad = 0.2;
            double& sag_rad = values[0];
            double& level_rad = values[1];
            const double beyond_rad = std::abs(level_rad) - maths::kPi / 2;
            if (beyond_rad < -kMargin_rad || (beyond_rad < kMargin_rad && sag_rad >= 0)) return;
            sag_rad = -sag_rad;
            level_rad -= std::copysign(maths::kPi, level_rad);
          },
      .proof = {{.values = {0.02, 0},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.05}},
                 .expected = {{"joint_rad", 0.482448348762193}},
                 .source = "python: 0.5 - p[0] * math.cos(0.5)"},
                {.values = {0.1, 0.3},
                 .given = {{"command_s", 0},
                           {"command_rad", 0.5},
                           {"command_s", 0.1},
                           {"command_rad", 0.2},
                           {"at_s", 0.2}},
                 .expected = {{"joint_rad", 0.100499583472197}},
                 .source = "python: 0.2 - p[0] * math.cos(0.2 - p[1])"}},
  };
}

}  // namespace seam::effects
