#include <cmath>
#include <vector>

#include "effects/effect.h"
#include "effects/stages/detector.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Lines through the whole of a room or a yard, in eight directions of their normals' axes: as far
// apart as each reaches, out to eight times that.
std::vector<std::vector<double>> lines() {
  constexpr int kTurns = 4, kFarthest = 8;
  std::vector<std::vector<double>> out;
  for (const double reach_m : {0.25, 0.5, 1.0, 2.0, 4.0, 8.0}) {
    for (int turn = 0; turn < kTurns; ++turn) {
      for (int step = -kFarthest; step <= kFarthest; ++step)
        out.push_back({0.1, turn * maths::kPi / kTurns, step * reach_m, reach_m});
    }
  }
  return out;
}

}  // namespace

EffectDefinition wall_excess() {
  return {
      .name = "wall_excess",
      .stage = Stage::detector,
      .kinds = kLandmarks,
      .parameters =
          {{.name = "size_m",
            .min = -20,
            .max = 20,
            .scale = 0.1,
            .help = "By how much ranges are too long at the line itself, metres.",
            .plausible = {-0.6, 3,
                          "a reflection that overlaps the direct path shifts its pulse by up to "
                          "the pulse's length, 0.6 m at 500 MHz of bandwidth (IEEE 802.15.4); "
                          "a blocked path is longer by metres"}},
           {.name = "direction_rad",
            .min = -3.2,
            .max = 3.2,
            .scale = 0.1,
            .help = "Where the line's normal points, radians in the frame of the map: 0 is a "
                    "wall at x = at_m, 1.5708 one at y = at_m."},
           {.name = "at_m",
            .min = -1000,
            .max = 1000,
            .scale = 0.2,
            .help = "Distance of the line from the map's origin along the normal, metres."},
           {.name = "reach_m",
            .neutral = 1,
            .min = 0.05,
            .max = 100,
            .scale = 0.2,
            .help = "Distance from the line at which 61 % of the error are left, metres.",
            .plausible = {0.1, 10, "paths that differ by more than a pulse no longer overlap"}}},
      .help =
          "Ranges are too long (or short) where the robot is near a line on the floor: a wall, a "
          "shelf of metal, a fence, whose reflections mix with the direct path.",
      .formula =
          "range + size exp(-d^2 / (2 reach^2)), d = x cos(direction) + y sin(direction) - "
          "at, x and y the detector's place",
      .signature = "an error at places of the robot, the same for all landmarks and in all runs",
      .example = "wall_excess: {size_m: 0.3, direction_rad: 1.5708, at_m: 4, reach_m: 0.8}",
      .needs = {Need::distances, Need::moving_view},
      .starts = {{kLandmarks, StartSearch::shapes, lines()}},
      .advice = {{kLandmarks,
                  {"range_wander", "landmark_bias"},
                  "Pass the place again, in another run: a wall's error stays where it is."},
                 {kLandmarks,
                  {},
                  "Go up to the wall and away from it, at several places along it, with landmarks "
                  "on all sides."}},
      .detector =
          [](Values p, Detection& seen) {
            if (p[0] == 0) return;
            const double d = seen.x_m * maths::cos(p[1]) + seen.y_m * maths::sin(p[1]) - p[2];
            seen.range_m += p[0] * maths::exp(-0.5 * d * d / (p[3] * p[3]));
          },
      .proof = {{.values = {0.3, 0, 2, 0.8},
                 .given = {{"range_m", 3}, {"x_m", 1.2}, {"y_m", 5}},
                 .expected = {{"range_m", 3.18195919791379}},
                 .source = "python: 3 + p[0] * math.exp(-(x_m - p[2])**2 / (2 * p[3]**2))"},
                {.values = {-0.1, 2.2, -1, 0.5},
                 .given = {{"range_m", 2}, {"bearing_rad", 0.3}, {"x_m", 0.4}, {"y_m", -1.1}},
                 .expected = {{"range_m", 1.90306440277081}, {"bearing_rad", 0.3}},
                 .source = "python: 2 + p[0] * math.exp(-(x_m * math.cos(p[1]) + y_m * "
                           "math.sin(p[1]) - p[2])**2 / (2 * p[3]**2)), bearing_rad"}},
  };
}

}  // namespace seam::effects
