#include "effects/stages/walk/locomotion.h"

namespace seam::effects {

// With tracker_offset this is the sensor's pose in the body, (l_x, l_y, l_theta) of Censi and
// others, Simultaneous calibration of odometry and sensor parameters for mobile robots, IEEE
// Transactions on Robotics 29(2), 2013. Markers that are stuck on by hand are a few degrees off.
EffectDefinition tracker_turn() {
  return {
      .name = "tracker_turn",
      .stage = Stage::locomotion,
      .kinds = kOdometry,
      .parameters = {{.name = "yaw_rad",
                      .min = -3.2,
                      .max = 3.2,
                      .scale = 0.02,
                      .help = "Where the tracker's own forward points, to the left of the body's, "
                              "radians.",
                      .plausible = {-3.15, 3.15,
                                    "a whole turn: frames of trackers point anywhere; marks that "
                                    "are put on by eye are within 0.1"}}},
      .help =
          "The measured heading is that of a marker which is turned on the body: the body seems to "
          "go aslant.",
      .formula = "theta + yaw of the tracker; the body moves along theta",
      .signature = "position errors across the heading, in proportion to the way ahead",
      .example = "tracker_turn: {yaw_rad: 0.03}",
      .needs = {Need::path},
      .advice = {{kOdometry,
                  {"heading_drift", "wheel_scale"},
                  "Drive straight ahead and back again: a marker that is turned shows the same "
                  "heading all the way, a drift another at the end."},
                 {kOdometry, {}, "Drive straight ahead: the way then shows where forward is."}},
      .tracker = [](Values p, Tracker& tracker) { tracker.yaw_rad += p[0]; },
      .proof =
          {{.values = {0.1},
            .given = {{"vx_mps", 0.3}, {"for_s", 2}},
            .expected = {{"x_m", 0.597002499166815},
                         {"y_m", -0.0599000499880969},
                         {"theta_rad", 0}},
            .source = "python: 0.6 * math.cos(p[0]), -0.6 * math.sin(p[0]), 0"},
           {.values = {-0.4},
            .given = {{"vx_mps", 0.2}, {"vy_mps", -0.1}, {"omega_radps", 0.5}, {"for_s", 2}},
            .expected = {{"x_m", 0.388631325292117}, {"y_m", 0.181231262905625}, {"theta_rad", 1}},
            .source =
                "python: math.cos(p[0]) * walked(p, [((0.2, -0.1, 0.5), 2)])[0] + math.sin(p[0]) * "
                "walked(p, [((0.2, -0.1, 0.5), 2)])[1], math.cos(p[0]) * walked(p, [((0.2, -0.1, "
                "0.5), 2)])[1] - math.sin(p[0]) * walked(p, [((0.2, -0.1, 0.5), 2)])[0], 1"}},
  };
}

}  // namespace seam::effects
