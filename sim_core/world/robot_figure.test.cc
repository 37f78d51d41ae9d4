// The bounds of a robot's figure against its parts, wherever random postures put them.
#include "sim_core/world/robot_figure.h"

#include <gtest/gtest.h>

#include "sim_core/base/random.h"
#include "sim_core/scene/bounding_ball.h"

namespace seam {
namespace {

RobotSpec ers210() {
  const std::string models = std::string(SEAM_SOURCE_DIR) + "/models/";
  return Scenario::from_text("format: seam-scenario/1\nname: t\nduration_s: 1\nfield: '" + models +
                                 "field_2002.yaml'\nrobots:\n  - {id: a, team: red, pose: {x_m: 0, "
                                 "y_m: 0, theta_rad: 0}, body: '" +
                                 models + "robot_ers210.yaml'}\n",
                             "test")
      .robots[0];
}

// A slide on a turn on a turn, and a joint that follows the first one.
RobotSpec arm() {
  RobotSpec spec;
  spec.body.tree.links = {{.name = "base"},
                          {.name = "upper",
                           .parent = "base",
                           .joint = "shoulder",
                           .motion = JointMotion::turn,
                           .translate_m = {0, 0, 0.2},
                           .axis = {0, 1, 0},
                           .limits = {-3, 3, 1}},
                          {.name = "lower",
                           .parent = "upper",
                           .joint = "elbow",
                           .motion = JointMotion::turn,
                           .translate_m = {0.3, 0, 0},
                           .axis = {0, 0, 1},
                           .limits = {-3, 3, 1}},
                          {.name = "rod",
                           .parent = "lower",
                           .joint = "reach",
                           .motion = JointMotion::slide,
                           .translate_m = {0.1, 0.05, 0},
                           .axis = {1, 0, 0},
                           .limits = {-3, 3, 1}},
                          {.name = "hand",
                           .parent = "rod",
                           .joint = "wrist",
                           .motion = JointMotion::turn,
                           .translate_m = {0.1, 0, 0},
                           .axis = {0, 0, 1},
                           .mimics = "shoulder",
                           .mimic_factor = -2}};
  EXPECT_EQ(spec.body.tree.connect(), std::nullopt);
  for (size_t link = 0; link < 5; ++link) {
    const auto shape = static_cast<Shape>(link);
    spec.body.parts.push_back({.link = link,
                               .shape = shape,
                               .centre_m = {0.02, -0.03, 0.04},
                               .rotate_rad = {0.3, 0.5, -0.8},
                               .size_m = {0.05, 0.06, 0.2}});
  }
  return spec;
}

Posture drawn(uint64_t trial, double spread) {
  const RandomStream stream{.seed = 7, .stream = trial};
  const auto draw = [&](uint64_t k) { return spread * (2 * uniform(stream, k) - 1); };
  Posture posture{.turn_rad = {draw(0), draw(1), draw(2)}, .p_WB = {draw(3), draw(4), draw(5)}};
  for (uint64_t j = 0; j < posture.joints_rad.size(); ++j) posture.joints_rad[j] = draw(6 + j);
  return posture;
}

Posture sum(const Posture& a, const Posture& b) {
  Posture posture{.turn_rad = a.turn_rad + b.turn_rad, .p_WB = a.p_WB + b.p_WB};
  for (size_t j = 0; j < a.joints_rad.size(); ++j)
    posture.joints_rad[j] = a.joints_rad[j] + b.joints_rad[j];
  return posture;
}

// Points of the ball about a primitive, in its own frame.
std::vector<Vec3> ball_points(const Primitive& primitive) {
  std::vector<Vec3> points = {bounding_centre(primitive)};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vec3 point = bounding_centre(primitive);
      point[axis] += side * bounding_radius(primitive);
      points.push_back(point);
    }
  }
  return points;
}

void expect_bounds(const RobotSpec& spec, double step, double closest) {
  const RobotFigure figure(spec, 2, RobotFigure::Parts::all);
  double nearest_radius = 0, nearest_motion = 0;
  for (uint64_t trial = 0; trial < 500; ++trial) {
    const Posture a = drawn(trial, 1.5);
    Posture change = drawn(1000 + trial, step);
    // One joint alone, all of them, or the body too.
    if (trial % 3 != 0) change.turn_rad = change.p_WB = Vec3(0.0);
    for (size_t j = 0; trial % 3 == 1 && j < change.joints_rad.size(); ++j)
      if (j != trial / 3 % change.joints_rad.size()) change.joints_rad[j] = 0;
    const Posture b = sum(a, change);
    std::vector<Primitive> at_a, at_b;
    figure.add_parts(a, at_a), figure.add_parts(b, at_b);
    ASSERT_EQ(at_a.size(), figure.part_count());
    const double bound_m = figure.motion_bound_m(a, b);
    for (size_t i = 0; i < at_a.size(); ++i) {
      for (const Vec3& p_O : ball_points(at_a[i])) {
        const double away_m = glm::length(at_a[i].X_WO * p_O - a.p_WB);
        const double moved_m = glm::length(at_b[i].X_WO * p_O - at_a[i].X_WO * p_O);
        ASSERT_LE(away_m, figure.radius_m()) << trial << " part " << i;
        ASSERT_LE(moved_m, bound_m + 1e-12) << trial << " part " << i;
        nearest_radius = std::max(nearest_radius, away_m / figure.radius_m());
        if (bound_m > 0) nearest_motion = std::max(nearest_motion, moved_m / bound_m);
      }
    }
  }
  EXPECT_GT(nearest_radius, closest);
  EXPECT_GT(nearest_motion, closest);
}

TEST(RobotFigure, BoundsHoldAllPartsOfAnErs210) {
  expect_bounds(ers210(), 0.002, 0.8);
  expect_bounds(ers210(), 0.5, 0.7);
}

TEST(RobotFigure, BoundsHoldAllPartsOfATreeOfLinks) {
  expect_bounds(arm(), 0.002, 0.5);
}

TEST(RobotFigure, AHeadIsNotInItsOwnPictures) {
  const RobotSpec spec = ers210();
  const RobotFigure all(spec, 2, RobotFigure::Parts::all);
  const RobotFigure own(spec, 2, RobotFigure::Parts::before_own_lens);
  EXPECT_EQ(all.part_count(), spec.body.parts.size());
  EXPECT_EQ(own.part_count(), all.part_count() - 4);  // A neck, and three parts of the head.
}

}  // namespace
}  // namespace seam
