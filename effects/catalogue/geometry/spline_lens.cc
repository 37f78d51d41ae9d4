#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "effects/effect.h"
#include "effects/stages/geometry.h"
#include "effects/stages/spline_grid.h"
#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Of four neighbouring control points on the way from the second to the third, and by that way.
struct Weights {
  int first;
  std::array<double, 4> value, slope;
};

// A uniform cubic B-spline; beyond its ends the last piece goes on.
Weights weights_at(double place, int count) {
  const int piece = std::clamp(static_cast<int>(std::floor(place)), 1, count - 3);
  const double t = place - piece, s = 1 - t;
  return {
      piece - 1,
      {s * s * s / 6, (4 + t * t * (3 * t - 6)) / 6, (1 + 3 * t * (1 + t * s)) / 6, t * t * t / 6},
      {-s * s / 2, t * (3 * t - 4) / 2, (1 + t * (2 - 3 * t)) / 2, t * t / 2}};
}

struct Bent {
  double x = 0, y = 0;
  double growth = 0;  // Of an image's area; not positive: the lens folds it over.
};

// Of a stereographic image point.
Bent bent(Values p, double x, double y) {
  const double half_fov_x = 2 * maths::tan(p[kSplineFov] * maths::kPi / 720);
  const double pieces = (kSplineColumns - 3) / (2 * half_fov_x);  // In a unit of x and y.
  const double column = pieces * x + 0.5 * (kSplineColumns - 1),
               row = pieces * y + 0.5 * (kSplineRows - 1);
  const bool inside =
      column >= 0 && column <= kSplineColumns - 1 && row >= 0 && row <= kSplineRows - 1;
  const Weights across = weights_at(column, kSplineColumns), down = weights_at(row, kSplineRows);
  std::array<double, 2> moved = {}, by_column = {}, by_row = {};
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (const int part : {0, 1}) {
        const double value = p[spline_place(down.first + i, across.first + j, part)];
        moved[part] += down.value[i] * across.value[j] * value;
        by_column[part] += down.value[i] * across.slope[j] * value;
        by_row[part] += down.slope[i] * across.value[j] * value;
      }
    }
  }
  const double growth = (1 + pieces * by_column[0]) * (1 + pieces * by_row[1]) -
                        pieces * by_row[0] * pieces * by_column[1];
  return {x + moved[0], y + moved[1], inside ? growth : -1};
}

void bend_by_splines(Values p, ImagePoint& point) {
  const Vec3& ray = point.p_C;
  const double length = std::sqrt(ray.x * ray.x + ray.y * ray.y + ray.z * ray.z);
  constexpr double kBehind = 1e-6;
  point.visible = length + ray.z > kBehind * length;
  if (!point.visible) return;
  const double x = 2 * ray.x / (length + ray.z), y = 2 * ray.y / (length + ray.z);
  const auto at = [&](double share) { return bent(p, share * x, share * y); };
  Bent image = at(1);
  point.visible = image.growth > 0;
  point.at_edge = !point.visible;
  if (point.at_edge) image = at(fold_before(1, [&](double share) { return at(share).growth; }));
  point.x = point.xd = image.x;
  point.y = point.yd = image.y;
}

std::vector<Parameter> spline_parameters() {
  std::vector<Parameter> all = {
      {.name = "fov_x_deg",
       .neutral = 90,
       .min = 5,
       .max = 300,
       .scale = 10,
       .help = "Angle of view between the second column of control points and the last but one, "
               "degrees; rows are as far apart as columns.",
       .required = true,
       .stated = true}};
  for (int row = 0; row < kSplineRows; ++row) {
    for (int column = 0; column < kSplineColumns; ++column) {
      for (const int part : {0, 1}) {
        all.push_back({.name = fmt::format("{}_{}_{}", part == 0 ? 'x' : 'y', row, column),
                       .min = -1,
                       .max = 1,
                       .scale = 0.01,
                       .help = fmt::format("Along {} at row {}, column {}.",
                                           part == 0 ? "rows" : "columns", row, column),
                       .stated = is_stated_of_splines(row, column, part)});
      }
    }
  }
  return all;
}

std::vector<Advice> spline_advice() {
  return {{kPoints,
           {},
           "Views whose points reach the corners of the image: splines know the lens only "
           "where points are."}};
}

}  // namespace

// The splined stereographic lens of mrcal (LENSMODEL_SPLINED_STEREOGRAPHIC, order 3): it can be any
// smooth lens, and says nothing of why it is so. With as many control points, lenses as the
// benchmark draws them are met to 0.04 px over the image by least squares.
EffectDefinition spline_lens() {
  return {
      .name = "spline_lens",
      .stage = Stage::geometry,
      .kinds = kPoints | kRanges | kFrames,
      .parameters = spline_parameters(),
      .help =
          "An empirical lens, in place of all others: a stereographic projection moved by cubic "
          "B-splines over control points, 6 rows from the top (0) and 8 columns from the left (0).",
      .formula =
          "u + sum of (x_ROW_COLUMN, y_ROW_COLUMN) times B-splines of u = 2 (X, Y) / (|p| + Z)",
      .signature = "smooth over the image, the same in all views, and of no lens's form",
      .example = "spline_lens: {fov_x_deg: 80, x_1_1: -0.02, y_4_5: 0.01}",
      .unknown_cause = true,
      .has_neutral = false,
      .replaces_terms = {Term::radial, Term::angular, Term::one_sided},
      .needs = {Need::wide_view},
      .advice = spline_advice(),
      .geometry = bend_by_splines,
      .proof =
          {{.values = {60,   0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05,
                       0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01,
                       0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02,
                       0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01},
            .given = {{"x_m", -0.45}, {"y_m", -0.3}, {"z_m", 1}},
            .expected = {{"u_px", 24.8858218680465}, {"v_px", 31.1909662520041}},
            .source = "python: 160 * spline_lens(p, x_m, y_m, z_m)[0] + 88.5, 162 * spline_lens(p, "
                      "x_m, y_m, z_m)[1] + 71.5"},
           {.values = {60,   0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05,
                       0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01,
                       0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02,
                       0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01},
            .given = {{"x_m", -0.45}, {"y_m", 0.3}, {"z_m", 1}},
            .expected = {{"u_px", 25.6084770161348}, {"v_px", 122.823969720529}},
            .source = "python: 160 * spline_lens(p, x_m, y_m, z_m)[0] + 88.5, 162 * spline_lens(p, "
                      "x_m, y_m, z_m)[1] + 71.5"},
           {.values = {60,   0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05,
                       0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01,
                       0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02,
                       0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01},
            .given = {{"x_m", 0.45}, {"y_m", -0.3}, {"z_m", 1}},
            .expected = {{"u_px", 160.822579457203}, {"v_px", 31.6345891697337}},
            .source = "python: 160 * spline_lens(p, x_m, y_m, z_m)[0] + 88.5, 162 * spline_lens(p, "
                      "x_m, y_m, z_m)[1] + 71.5"},
           {.values = {60,   0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05,
                       0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01,
                       0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02,
                       0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03,
                       0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04, 0.01, 0.03, 0.05, 0.02, 0.04,
                       0.01, 0.03, 0.05, 0.02, 0.04, 0.01},
            .given = {{"x_m", 0.45}, {"y_m", 0.3}, {"z_m", 1}},
            .expected = {{"u_px", 160.608935209813}, {"v_px", 121.917909264866}},
            .source = "python: 160 * spline_lens(p, x_m, y_m, z_m)[0] + 88.5, 162 * spline_lens(p, "
                      "x_m, y_m, z_m)[1] + 71.5"}},
  };
}

}  // namespace seam::effects
