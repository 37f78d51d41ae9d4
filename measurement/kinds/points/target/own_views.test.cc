// What differs from view to view, a focal length or a motion while the rows are read: found as that
// in sets that are made here by formulas of their own, and not where there is none, nor where a
// pane before the lens shifts rays.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "measurement/kinds/kinds.h"
#include "measurement/kinds/points/views_testing.h"
#include "measurement/search/search.h"
#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

constexpr int kColumns = 9, kCorners = kColumns * 6;

struct Spreads {
  double focal = 0;                // Of a view's focal length, as a share.
  double way_m = 0, turn_rad = 0;  // While an image is read.
  double aside_m = 0;              // Of rays at the image's edge, by a pane before the lens.
  bool facing = false;             // The board stands square to the axis.
};

// 24 views of 9 x 6 corners, 600 px in 640 x 480.
std::filesystem::path made(const std::string& name, const Spreads& spreads, uint64_t seed) {
  std::string rows;
  for (int frame = 0; frame < 24; ++frame) {
    const auto own = [&](int k) { return normal({seed, 1}, static_cast<uint64_t>(8 * frame + k)); };
    const double focal = 600 * (1 + spreads.focal * own(0));
    const double around = 2.4 * frame, roll = 0.7 * frame;
    const double tilt = spreads.facing ? 0 : frame % 3 == 0 ? 0.25 : 0.6;
    const double yaw = tilt * std::cos(around), pitch = tilt * std::sin(around);
    for (int point = 0; point < kCorners; ++point) {
      const double a = 0.03 * (point % kColumns - 4), b = 0.03 * (point / kColumns - 2.5);
      const double x1 = std::cos(roll) * a - std::sin(roll) * b,
                   y1 = std::sin(roll) * a + std::cos(roll) * b;
      const double y2 = std::cos(pitch) * y1 + 0.03 * (frame % 2), z2 = std::sin(pitch) * y1;
      const double x3 = std::cos(yaw) * x1 + std::sin(yaw) * z2 + 0.03 * (frame % 3 - 1),
                   z3 = -std::sin(yaw) * x1 + std::cos(yaw) * z2 + 0.5 + 0.03 * (frame % 5);
      double u = 0, v = 239.5;
      for (int round = 0; round < 20; ++round) {  // The row says how far the point has come.
        const double part = v / 480 - 0.5, way = part * spreads.way_m,
                     turn = part * spreads.turn_rad;
        const double aside = spreads.aside_m * std::pow(x3 / z3 / 0.53 + 0.5, 2);
        const double x = x3 + aside + way * own(1) + turn * (own(5) * z3 - own(6) * y2),
                     y = y2 + way * own(2) + turn * (own(6) * x3 - own(4) * z3),
                     z = z3 + way * own(3) + turn * (own(4) * y2 - own(5) * x3);
        u = focal * x / z + 319.5, v = focal * y / z + 239.5;
      }
      const auto draw = static_cast<uint64_t>(2 * (frame * kCorners + point));
      u += 0.1 * normal({seed, 2}, draw), v += 0.1 * normal({seed, 2}, draw + 1);
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      rows +=
          fmt::format("{},{},{},{:.6f},{:.6f},0,{:.4f},{:.4f}\n", frame, frame, point, a, b, u, v);
    }
  }
  return write_views("own-views-" + name, rows);
}

SearchResult searched(const std::filesystem::path& folder) {
  const Model nominal = Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\neffects: {pinhole: {fx_px: {value: 590, free: true}, fy_px: {value: "
      "590, free: true}, cx_px: {value: 319.5, free: true}, cy_px: {value: 239.5, free: true}}}\n",
      "nominal"));
  const auto problem = open_problem(folder);
  return search(*problem, nominal, {}, [](const std::string&) {});
}

TEST(OwnViews, AFocalLengthOfEachIsFoundWithItsSpread) {
  const SearchResult result = searched(made("focus", {.focal = 0.015}, 1));
  const Model& model = result.best.assessment.model;
  ASSERT_TRUE(model.has("focus_variation")) << model.to_yaml();
  EXPECT_EQ(result.steps.size(), 1u) << model.to_yaml();
  // Of 24 draws the spread is known to 14 %.
  EXPECT_NEAR(model.find("focus_variation")->value("sigma"), 0.015, 0.006);
  // The mean of these draws has a standard error of 600 * 0.015 / sqrt(24) px.
  EXPECT_NEAR(model.find("pinhole")->value("fx_px"), 600, 4 * 1.84);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
}

// 0.5 rad/s and 0.15 m/s over rows that are read in 14 ms.
TEST(OwnViews, AMotionOfEachIsFoundWithItsSpreads) {
  const SearchResult result = searched(made("motion", {.way_m = 0.002, .turn_rad = 0.007}, 1));
  const Model& model = result.best.assessment.model;
  ASSERT_TRUE(model.has("view_motion")) << model.to_yaml();
  EXPECT_EQ(result.steps.size(), 1u) << model.to_yaml();
  // Of 72 draws a spread is known to 8 %.
  EXPECT_NEAR(model.find("view_motion")->value("turn_sigma_rad"), 0.007, 0.002);
  EXPECT_NEAR(model.find("pinhole")->value("fx_px"), 600, 4 * 0.5);
  EXPECT_NEAR(result.best.assessment.error, 1, 0.06);
}

// A pane does not bend each view in a way of its own: what it does counts the more the nearer.
TEST(OwnViews, APaneIsNoMotion) {
  const SearchResult result = searched(made("pane", {.aside_m = 0.006}, 7));
  EXPECT_TRUE(result.steps.empty()) << result.best.assessment.model.to_yaml();
  ASSERT_TRUE(result.unnamed);
  EXPECT_THAT(result.unnamed->depends_on[0], testing::Contains("distance"));
  EXPECT_LT(result.unnamed->error_after, 1.1);
}

// A board square to the axis is nearer as well as seen by a longer focal length.
TEST(OwnViews, WhatPosesCanFollowSaysNothingOfASpread) {
  const auto problem = open_problem(made("facing", {.facing = true}, 4));
  const auto likelihood = [&](const std::string& more) {
    const Model model = Model::from_config(ConfigNode::from_text(
        "format: seam-model/1\neffects: {pinhole: {fx_px: 600, fy_px: 600, cx_px: 319.5, cy_px: "
        "239.5}" +
            more + "}\n",
        "model"));
    return problem->score(model, problem->all_groups()).log_likelihood;
  };
  EXPECT_NEAR(likelihood(", focus_variation: {sigma: 0.015}"), likelihood(""), 0.5);
}

TEST(OwnViews, NothingIsFoundWhereTheyAreAlike) {
  for (const uint64_t seed : {2, 3}) {
    const SearchResult result = searched(made(fmt::format("alike-{}", seed), {}, seed));
    EXPECT_TRUE(result.steps.empty()) << result.best.assessment.model.to_yaml();
  }
}

}  // namespace
}  // namespace seam::measurement
