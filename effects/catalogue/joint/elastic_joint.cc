#include <limits>
#include <vector>

#include "effects/stages/servo.h"

namespace seam::effects {
namespace {

std::vector<std::vector<double>> coarse_look() {
  std::vector<std::vector<double>> values;
  for (const double hertz : {2.0, 3.0, 4.5, 6.7, 10.0, 15.0, 22.0}) values.push_back({hertz, 0.12});
  return values;
}

}  // namespace

// Spong, Modeling and control of elastic joint robots, Journal of Dynamic Systems 109, 1987; the
// damper as in De Luca and Book, Robots with flexible elements (Springer Handbook of Robotics).
// What the load does to the drive is left out. Plausible: joints of arms and heads swing at 2 to 30
// Hz, damped by 0.01 to 0.3.
EffectDefinition elastic_joint() {
  return {
      .name = "elastic_joint",
      .stage = Stage::joint,
      .kinds = kJoints | kRanges,
      .parameters = {{.name = "frequency_hz",
                      .neutral = std::numeric_limits<double>::infinity(),
                      .min = 0.3,
                      .max = 200,
                      .scale = 10,
                      .help = "At which the load swings on the drive that holds still, hertz.",
                      .fit_reciprocal = true},
                     {.name = "damping",
                      .min = 0,
                      .max = 0.95,
                      .scale = 0.1,
                      .help = "Share of the damping at which the load no longer swings."}},
      .help =
          "The load hangs on the drive by a spring: gears, a belt or a link that bend. Two masses, "
          "of which the load does not move the drive.",
      .formula =
          "d2q/dt2 = w^2 (m - q) + 2 damping w (dm/dt - dq/dt), w = 2 pi frequency, m the drive",
      .signature = "swings at one frequency after steps and stops, whatever the gain",
      .example = "elastic_joint: {frequency_hz: 8, damping: 0.1}",
      .starts = {{kJoints, StartSearch::best_listed, coarse_look()}},
      .advice =
          {{kJoints,
            {"motor_servo", "acceleration_limit"},
            "the same steps at two gains: a controller's swing changes its frequency with the "
            "gain, that of an elastic joint does not"},
           {kJoints, {}, "steps that end between rows that are close to each other"}},
      .servo = [](Values p,
                  ServoModel& servo) { servo.elastic = {.frequency_hz = p[0], .damping = p[1]}; },
      .proof =
          {{.values = {4, 0.2},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"at_s", 0.1}},
            .expected = {{"joint_rad", 1.54827076150994}},
            .source = "python: 1 - math.exp(-p[1] * 8 * math.pi * at_s) * (math.cos(8 * math.pi * "
                      "math.sqrt(1 - p[1]**2) * at_s) - p[1] / math.sqrt(1 - p[1]**2) * math.sin(8 "
                      "* math.pi * math.sqrt(1 - p[1]**2) * at_s))"},
           {.values = {10, 0.05},
            .given = {{"command_s", 0}, {"command_rad", 1}, {"limit_radps", 2}, {"at_s", 0.17}},
            .expected = {{"joint_rad", 0.357689998066416}},
            .source = "python: elastic(p, lambda t: 2 * t, lambda t: 2, at_s)",
            .tolerance = 1e-07}},
  };
}

}  // namespace seam::effects
