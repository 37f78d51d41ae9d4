#include <gtest/gtest.h>

#include <cmath>

#include "robot_sdk/team/skills.h"

namespace seam::sdk {
namespace {

Percepts ball_at(float time_s, float distance_m, float bearing_rad) {
  const BallSighting ball{.distance_m = distance_m, .bearing_rad = bearing_rad};
  return {.time_s = time_s, .ball = ball, .has_frame = true};
}

// A player that has looked at the landmarks long enough to know where it is.
WorldModel placed_at(const FieldPose& truth, int player = 2) {
  WorldModel world(player, true, 11);
  std::vector<LandmarkSighting> sightings;
  for (const LandmarkPosition& landmark : standard_landmarks()) {
    const float dx = landmark.x_m - truth.x_m, dy = landmark.y_m - truth.y_m;
    const float bearing = std::remainder(std::atan2(dy, dx) - truth.theta_rad, 6.2831853f);
    sightings.push_back({.kind = landmark.kind, .bearing_rad = bearing, .range_m = std::sqrt(dx * dx + dy * dy),
                         .bearing_sigma_rad = 0.01f, .range_sigma_m = 0.05f});
  }
  for (int i = 0; i < 80; ++i) world.update({.time_s = 0.04f * i, .landmarks = {sightings[i % sightings.size()]}});
  return world;
}

TEST(WorldModel, BallStaysInPlaceWhileTheBodyTurns) {
  WorldModel world(2, true, 1);
  world.update(ball_at(1, 1.0f, 0));
  world.update({.time_s = 1.1f, .odometry_step = {0, 0, 0.5f}});
  EXPECT_NEAR(world.ball().bearing_rad(), -0.5f, 1e-5f);
  world.update({.time_s = 1.2f, .odometry_step = {0.2f, 0, 0}});
  EXPECT_NEAR(world.ball().x_m, std::cos(0.5f) - 0.2f, 1e-5f);
}

TEST(WorldModel, BelievesATeamMateWhenTheBallIsOutOfSight) {
  WorldModel world = placed_at({0, 0, 0});
  const TeamMessage told{.player = 1, .sees_ball = true, .ball_x_m = 1, .ball_y_m = 0, .ball_distance_m = 0.4f};
  world.update({.time_s = 10, .messages = {told}});
  EXPECT_TRUE(world.ball().told);
  EXPECT_NEAR(world.ball().distance_m(), 1, 0.15f);
  EXPECT_FALSE(world.is_nearest_to_ball());
}

TEST(Play, ApproachesThenKicksTowardsTheGoal) {
  WorldModel world = placed_at({1.0f, 0, 0});
  world.update(ball_at(4, 0.8f, 0.1f));
  const Action far = play(world, Role::attacker);
  EXPECT_STREQ(far.name, "approach");
  EXPECT_GT(far.vx_mps, 0.05f);
  world.update(ball_at(6.5f, 0.18f, 0.05f));
  EXPECT_TRUE(play(world, Role::attacker).kick);
}

TEST(Play, NeverKicksTowardsTheOwnGoal) {
  WorldModel world = placed_at({-1.0f, 0, 3.1f});
  world.update(ball_at(4, 0.18f, 0.0f));
  EXPECT_FALSE(play(world, Role::attacker).kick);
  EXPECT_FALSE(play(world, Role::goalie).kick);
}

TEST(Play, SearchesWhenTheBallIsUnknown) {
  const WorldModel world = placed_at({0, 0, 0});
  EXPECT_STREQ(play(world, Role::attacker).name, "search");
}

}  // namespace
}  // namespace seam::sdk
