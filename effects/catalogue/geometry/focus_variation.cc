#include <cmath>

#include "effects/stages/target.h"

namespace seam::effects {

EffectDefinition focus_variation() {
  return {
      .name = "focus_variation",
      .stage = Stage::geometry,
      .kinds = kPoints,
      .parameters =
          {{.name = "sigma",
            .min = 0,
            .max = 0.2,
            .scale = 0.005,
            .help = "One sigma of a view's focal length, as a share of it.",
            .plausible =
                {0, 0.05,
                 "focusing from infinity to near changes the angle of view by up to 5 %"}}},
      .help =
          "The focal length differs from view to view: autofocus, or a zoom ring that moved. Each "
          "view has one draw, which is estimated with its pose.",
      .formula =
          "cx + (1 + e) (u - cx), cy + (1 + e) (v - cy), e from N(0, sigma^2) for each view of "
          "each camera",
      .signature = "radial from the principal point, another size in each view",
      .example = "focus_variation: {sigma: 0.01}",
      .spread_only = true,
      .draws_estimated = true,
      .needs = {Need::several_views, Need::still_views},
      .starts = {{kPoints, StartSearch::listed, {{0.005}}}},
      .advice = {{kPoints,
                  {},
                  "Switch autofocus off, lock the zoom, and take the views again; if the scatter "
                  "stays, it was not the focal length."},
                 {kOutcomes,
                  {},
                  "it is one draw for each view of a calibration: leave it out, or let the focal "
                  "length change with time (focal_drift)"}},
      .target =
          [](Values p, TargetShape& shape) {
            shape.focus_sigma = std::sqrt(shape.focus_sigma * shape.focus_sigma + p[0] * p[0]);
          },
      .proof = {{.values = {0.015},
                 .given = {{"x_m", 0.3}, {"y_m", -0.2}, {"z_m", 1.25}},
                 .expected = {{"u_px", 126.9},
                              {"u_focus_sigma_px", 0.576},
                              {"v_focus_sigma_px", 0.3888}},
                 .source = "python: 160 * 0.24 + 88.5, p[0] * 160 * 0.24, p[0] * 162 * 0.16"},
                {.values = {0.1},
                 .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 0.75}},
                 .expected = {{"u_focus_sigma_px", 9.6}, {"v_focus_sigma_px", 6.48}},
                 .source = "python: p[0] * 160 * 0.6, p[0] * 162 * 0.4"}},
  };
}

}  // namespace seam::effects
