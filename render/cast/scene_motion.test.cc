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
  SceneInstant instant{.time = time, .X_WC = head_camera(0.2, 0, 0, 0)};
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

double image_motion_px(const SceneInstant& a, const SceneInstant& b) {
  ImageMotion motion(a.X_WC, b.X_WC);
  motion.add_all(a.primitives, b.primitives);
  return kFocal_px * motion.most();
}

TEST(SceneBetweenInstants, WhatOneInstantLacksIsNoMotion) {
  const SimTime start = SimTime::from_s(1), end = SimTime::from_s(1.01);
  const double whole = image_motion_px(objects(0, start, {}), objects(kMoved_m, end, {}));
  EXPECT_GT(whole, 0.2);
  EXPECT_LT(whole, 0.5);
  for (const std::vector<uint16_t>& left_out :
       {std::vector<uint16_t>{1}, {5}, {8}, {5, 3}, {1, 8}}) {
    EXPECT_LE(image_motion_px(objects(0, start, left_out), objects(kMoved_m, end, {})), whole);
    EXPECT_LE(image_motion_px(objects(0, start, {}), objects(kMoved_m, end, left_out)), whole);
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

// Random objects that move and turn at random, near and far, beside a slow one: the quick look at
// whether it moves more leaves none out that does.
TEST(SceneBetweenInstants, WhatMovesMostIsFound) {
  int faster = 0;
  for (uint64_t trial = 0; trial < 400; ++trial) {
    const auto draw = [&](uint64_t k, double low, double high) {
      return low + (high - low) * uniform({.seed = 4, .stream = trial}, k);
    };
    Primitive primitive{.shape = static_cast<Shape>(trial % 5), .rgb = {1, 1, 1}};
    primitive.size = {draw(0, 0.01, 0.5), draw(1, 0.01, 0.5), draw(2, 0.01, 0.5)};
    primitive.X_WO = {rotation_zyx(draw(3, -3, 3), draw(4, -1, 1), draw(5, -3, 3)),
                      {draw(6, 0.2, 4), draw(7, -2, 2), draw(8, -0.5, 0.5)}};
    Primitive moved = primitive;
    const double turn = trial % 3 == 0 ? 0 : 0.1;
    moved.X_WO.p += Vec3(draw(10, 0, 0.01), draw(11, 0, 0.01), draw(12, 0, 0.01));
    moved.X_WO.R = moved.X_WO.R * rotation_zyx(draw(13, 0, turn), 0, draw(14, 0, turn));
    const Pose X_WC = head_camera(0.2, 0, 0, 0);
    const double slow_m = draw(15, 0, 0.02);
    const Primitive slow = sphere({1, 0, 0.2}, 0.05, {1, 1, 1}),
                    slow_moved = sphere({1, slow_m, 0.2}, 0.05, {1, 1, 1});
    ImageMotion alone(X_WC, X_WC), slow_alone(X_WC, X_WC), behind_slow(X_WC, X_WC);
    alone.add(primitive, moved);
    slow_alone.add(slow, slow_moved);
    behind_slow.add(slow, slow_moved), behind_slow.add(primitive, moved);
    EXPECT_EQ(behind_slow.most(), std::max(alone.most(), slow_alone.most())) << trial;
    EXPECT_NEAR(slow_alone.most(), slow_m / 0.95, 1e-9);
    faster += alone.most() > slow_alone.most() && alone.most() < 2 * slow_alone.most();
  }
  EXPECT_GT(faster, 50);
}

}  // namespace
}  // namespace seam::render
