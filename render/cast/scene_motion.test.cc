// Scenes between two instants, of which one may lack what stands behind the camera.
#include "render/cast/scene_motion.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/test_scenes.h"

namespace seam::render {
namespace {

using namespace testing;

// Objects of three parts each, all moving by `moved_m` to the left; those in `left_out` are not
// there.
SceneInstant objects(double moved_m, SimTime time, const std::vector<uint16_t>& left_out) {
  SceneInstant instant{.time = time, .X_WC = head_camera(0.2, 0, 0, 0), .primitives = {}};
  for (const uint16_t id : {uint16_t{1}, uint16_t{5}, uint16_t{3}, uint16_t{8}}) {
    if (std::find(left_out.begin(), left_out.end(), id) != left_out.end()) continue;
    for (int part = 0; part < 3; ++part) {
      Primitive primitive =
          part == 1 ? box({2.0 + part, 0.3 * id + moved_m, 0.1}, {0.1, 0.1, 0.1}, 0, {1, 0, 0})
                    : sphere({2.0 + part, 0.3 * id + moved_m, 0.1}, 0.05, {0, 1, 0});
      primitive.object_id = id;
      instant.primitives.push_back(primitive);
    }
  }
  return instant;
}

constexpr double kFocal_px = 160, kMoved_m = 0.004;

TEST(SceneBetweenInstants, WhatOneInstantLacksIsNoMotion) {
  const SimTime start = SimTime::from_s(1), end = SimTime::from_s(1.01);
  const double whole =
      image_motion_px(objects(0, start, {}), objects(kMoved_m, end, {}), kFocal_px);
  EXPECT_GT(whole, 0.2);
  EXPECT_LT(whole, 0.5);
  for (const std::vector<uint16_t>& left_out :
       {std::vector<uint16_t>{1}, {5}, {8}, {5, 3}, {1, 8}}) {
    EXPECT_LE(image_motion_px(objects(0, start, left_out), objects(kMoved_m, end, {}), kFocal_px),
              whole);
    EXPECT_LE(image_motion_px(objects(0, start, {}), objects(kMoved_m, end, left_out), kFocal_px),
              whole);
  }
}

TEST(SceneBetweenInstants, WhatBothHaveMovesAllTheSame) {
  const SimTime start = SimTime::from_s(1), middle = SimTime::from_s(1.004),
                end = SimTime::from_s(1.01);
  // The later instant lacks an object, the nearer one has it: there it stays, all else moves on.
  const SceneInstant between =
      interpolate(objects(0, start, {}), objects(kMoved_m, end, {5}), middle);
  const SceneInstant before = objects(0, start, {});
  ASSERT_EQ(between.primitives.size(), before.primitives.size());
  for (size_t i = 0; i < before.primitives.size(); ++i) {
    const double moved = between.primitives[i].X_WO.p.y - before.primitives[i].X_WO.p.y;
    EXPECT_NEAR(moved, before.primitives[i].object_id == 5 ? 0 : 0.4 * kMoved_m, 1e-12) << i;
  }
}

// Random objects that move and turn at random, near and far: the quick bound is never the smaller.
TEST(SceneBetweenInstants, TheQuickBoundHoldsTheOther) {
  int close = 0;
  for (uint64_t trial = 0; trial < 400; ++trial) {
    const auto draw = [&](uint64_t k, double low, double high) {
      return low + (high - low) * uniform({.seed = 4, .stream = trial}, k);
    };
    Primitive primitive{.shape = static_cast<Shape>(trial % 5), .rgb = {1, 1, 1}};
    primitive.size = {draw(0, 0.01, 0.5), draw(1, 0.01, 0.5), draw(2, 0.01, 0.5)};
    primitive.X_WO = {rotation_zyx(draw(3, -3, 3), draw(4, -1, 1), draw(5, -3, 3)),
                      {draw(6, 0.2, 4), draw(7, -2, 2), draw(8, -0.5, 0.5)}};
    SceneInstant from{.time = SimTime(), .X_WC = head_camera(0.2, 0, 0, 0)};
    SceneInstant to{.time = SimTime::from_s(0.001),
                    .X_WC = head_camera(0.2, 0, draw(9, 0, 0.01), 0)};
    from.primitives = {primitive};
    const double turn = trial % 3 == 0 ? 0 : 0.1;
    primitive.X_WO.p += Vec3(draw(10, 0, 0.01), draw(11, 0, 0.01), draw(12, 0, 0.01));
    primitive.X_WO.R = primitive.X_WO.R * rotation_zyx(draw(13, 0, turn), 0, draw(14, 0, turn));
    to.primitives = {primitive};
    const double exact = image_motion_px(from, to, kFocal_px);
    const double bound = image_motion_bound_px(from, to, kFocal_px);
    EXPECT_GE(bound, exact) << trial;
    close += bound < 8 * exact;
  }
  EXPECT_GT(close, 300);
}

}  // namespace
}  // namespace seam::render
