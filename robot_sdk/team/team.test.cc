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
    sightings.push_back({.kind = landmark.kind,
                         .bearing_rad = bearing,
                         .range_m = std::sqrt(dx * dx + dy * dy),
                         .bearing_sigma_rad = 0.01f,
                         .range_sigma_m = 0.05f});
  }
  for (int i = 0; i < 80; ++i)
    world.update({.time_s = 0.04f * i, .landmarks = {sightings[i % sightings.size()]}});
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
  const TeamMessage reported{
      .player = 1, .sees_ball = true, .ball_x_m = 1, .ball_y_m = 0, .ball_distance_m = 0.4f};
  world.update({.time_s = 10, .messages = {reported}});
  EXPECT_TRUE(world.ball().reported);
  EXPECT_NEAR(world.ball().distance_m(), 1, 0.15f);
  EXPECT_FALSE(world.is_nearest_to_ball());
}

TEST(WorldModel, BelievesABallThatJumpsOnlyOnItsSecondSighting) {
  WorldModel world = placed_at({0, 0, 0});
  world.update(ball_at(4.00f, 1.0f, 0));
  world.update(ball_at(4.04f, 1.0f, 1.2f));
  EXPECT_NEAR(world.ball().bearing_rad(), 0, 0.05f);
  world.update(ball_at(4.08f, 1.0f, 0));
  EXPECT_NEAR(world.ball().bearing_rad(), 0, 0.05f);
  world.update(ball_at(4.12f, 1.0f, 1.2f));
  world.update(ball_at(4.16f, 1.0f, 1.2f));
  EXPECT_NEAR(world.ball().bearing_rad(), 1.2f, 0.05f);
}

TEST(WorldModel, TakesNothingOutsideTheWallsForTheBall) {
  WorldModel world = placed_at({1.5f, 0, 0});
  world.update(ball_at(4, 2.5f, 0));
  EXPECT_GT(world.ball_age_s(), 100);
  world.update(ball_at(4.1f, 0.5f, 0));
  EXPECT_EQ(world.ball_age_s(), 0);
}

TEST(WorldModel, KnowsWhereTheRefereeLaysTheBallAndPutsTheRobot) {
  WorldModel world = placed_at({-1.0f, 0.5f, 0});
  world.update({.time_s = 4, .situation = {.phase = Situation::set}});
  EXPECT_NEAR(world.ball().distance_m(), std::sqrt(1.25f), 0.15f);
  EXPECT_TRUE(world.ball().reported);
  world.update({.time_s = 5, .situation = {.phase = Situation::playing}});
  ASSERT_TRUE(world.home().has_value());
  // Two metres on, into the other half: at the next `set` the referee carries it back, and a single
  // landmark is enough to believe it.
  for (int i = 0; i < 20; ++i) {
    world.update(
        {.time_s = 6, .odometry_step = {0.1f, 0, 0}, .situation = {.phase = Situation::playing}});
  }
  EXPECT_NEAR(world.pose().mean.x_m, 1.0f, 0.3f);
  world.update({.time_s = 20, .situation = {.phase = Situation::set}});
  const LandmarkSighting seen{.kind = LandmarkKind::goal_skyblue,
                              .bearing_rad = std::atan2(-0.5f, 3.25f),
                              .range_m = std::sqrt(0.25f + 3.25f * 3.25f),
                              .bearing_sigma_rad = 0.01f,
                              .range_sigma_m = 0.1f};
  for (int i = 0; i < 8; ++i)
    world.update({.time_s = 20, .landmarks = {seen}, .situation = {.phase = Situation::set}});
  EXPECT_NEAR(world.pose().mean.x_m, -1.0f, 0.25f);
  EXPECT_NEAR(world.pose().mean.y_m, 0.5f, 0.25f);
}

TEST(WorldModel, ComesBackFromAPenaltyAtTheHalfWayLine) {
  WorldModel world = placed_at({1.0f, 0.5f, 0});
  world.update({.time_s = 5, .situation = {.phase = Situation::playing, .penalised = true}});
  world.update({.time_s = 35, .situation = {.phase = Situation::playing}});
  EXPECT_NEAR(world.pose().mean.x_m, -0.15f, 0.1f);
  EXPECT_NEAR(std::abs(world.pose().mean.y_m), 1.15f, 0.1f);
}

TEST(Play, ApproachesThenGrabsThenKicksTowardsTheGoal) {
  WorldModel world = placed_at({1.0f, -0.15f, 0});
  Player player(Role::attacker);
  world.update(ball_at(4, 0.8f, 0.1f));
  const Action far = player.play(world);
  EXPECT_STREQ(far.name, "approach");
  EXPECT_GT(far.vx_mps, 0.05f);
  world.update(ball_at(6.5f, 0.15f, 0.05f));
  EXPECT_EQ(player.play(world).kick, Kick::grab);
  world.update(ball_at(6.6f, 0.15f, 0.0f));
  EXPECT_EQ(player.play(world).kick, Kick::none);  // It looks whether the ball is there.
  Percepts turned = ball_at(7.0f, 0.15f, 0.0f);
  turned.odometry_step.theta_rad = 0.14f;  // Until the goal is ahead.
  world.update(turned);
  EXPECT_EQ(player.play(world).kick, Kick::leg_forward);
}

TEST(Play, ABallThatWasKickedIsNotGrabbedAgainUnseen) {
  WorldModel world = placed_at({1.0f, -0.15f, 0});
  Player player(Role::attacker);
  world.update(ball_at(6.5f, 0.15f, 0.05f));
  player.play(world);
  world.hold_ball(true);
  world.update({.time_s = 7.0f, .odometry_step = {0, 0, 0.14f}});
  EXPECT_EQ(player.play(world).kick, Kick::leg_forward);
  world.hold_ball(false);
  world.update({.time_s = 7.03f});
  EXPECT_EQ(player.play(world).kick, Kick::none);
}

TEST(Play, LeavesTheBallAtTheOpponentsKickOff) {
  WorldModel world = placed_at({-0.5f, 0, 0});
  Player player(Role::attacker);
  world.update({.time_s = 4, .situation = {.phase = Situation::set}});
  world.update({.time_s = 5, .situation = {.phase = Situation::playing}});
  EXPECT_STREQ(player.play(world).name, "hold");
  world.update({.time_s = 6,
                .ball = BallSighting{.distance_m = 0.5f, .bearing_rad = 1.0f},
                .has_frame = true,
                .situation = {.phase = Situation::playing}});
  EXPECT_STREQ(player.play(world).name, "approach");
}

TEST(Play, KicksAtOnceWhenItStandsBehindTheBall) {
  WorldModel world = placed_at({1.0f, 0, 0});
  Player player(Role::attacker);
  world.update(ball_at(6.5f, 0.15f, 0.05f));
  EXPECT_EQ(player.play(world).kick, Kick::leg_forward);
}

TEST(Play, ForgetsAGrabThatFailed) {
  WorldModel world = placed_at({1.0f, 0, 1.2f});
  Player player(Role::attacker);
  world.update(ball_at(6.5f, 0.15f, 0.05f));
  EXPECT_EQ(player.play(world).kick, Kick::grab);
  world.update(ball_at(7.6f, 0.5f, 0.3f));
  EXPECT_STREQ(player.play(world).name, "approach");
}

TEST(Play, NeverKicksTowardsTheOwnGoal) {
  for (const Role role : {Role::attacker, Role::goalie}) {
    WorldModel world = placed_at({-1.0f, 0, 3.1f});
    Player player(role);
    world.update(ball_at(4, 0.15f, 0.0f));
    EXPECT_EQ(player.play(world).kick, Kick::grab);
    for (float time_s = 4.1f; time_s < 8; time_s += 0.1f) {
      world.update(ball_at(time_s, 0.15f, 0.0f));
      const Action action = player.play(world);
      EXPECT_NE(action.kick, Kick::leg_forward);
      if (action.kick == Kick::release) break;
      EXPECT_LT(time_s, 7.0f);  // The referee allows three seconds.
    }
  }
}

TEST(Play, SearchesWhenTheBallIsUnknown) {
  const WorldModel world = placed_at({0, 0, 0});
  EXPECT_STREQ(Player(Role::attacker).play(world).name, "search");
}

}  // namespace
}  // namespace seam::sdk
