// Radio, referee and sensors of a match.
#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/maths.h"
#include "sim_core/world/radio.h"
#include "sim_core/world/referee.h"
#include "sim_core/world/world.h"

namespace seam {
namespace {

const std::string kRulesSource = SEAM_SOURCE_DIR;

Scenario rules_match() {
  return Scenario::from_file(kRulesSource + "/scenarios/match.yaml");
}

SimTime at(double s) {
  return SimTime::from_s(s);
}

Radio radio_of(const RadioSpec& spec, uint64_t seed = 5) {
  return Radio(spec, {"a", "b", "c", "x"}, {Team::red, Team::red, Team::red, Team::blue},
               {seed, 0});
}

TEST(Radio, ArrivesAfterLatencyAndTransmissionAtTeamMatesOnly) {
  const RadioSpec spec{.latency = SimDuration::from_s(0.02), .bytes_per_s = 1000};
  Radio radio = radio_of(spec);
  const std::vector<Pose2> places(4);
  radio.send(0, std::string(100, 'm'), at(1), places);  // 0.1 s on air.
  radio.send(0, "n", at(1), places);                    // Waits for the first.
  EXPECT_TRUE(radio.received(1, at(1.1199), at(0)).empty());
  ASSERT_EQ(radio.received(1, at(1.12), at(0)).size(), 1u);
  const auto all = radio.received(2, at(2), at(0));
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].arrived, at(1.121));
  EXPECT_EQ(all[1].from, "a");
  EXPECT_EQ(all[0].payload, std::string(100, 'm'));
  EXPECT_TRUE(radio.received(3, at(2), at(0)).empty());
  EXPECT_TRUE(radio.received(0, at(2), at(0)).empty());
  EXPECT_TRUE(radio.received(1, at(2), at(1.5)).empty());
}

TEST(Radio, RangeAndFullQueueStopMessages) {
  const RadioSpec spec{.range_m = 3, .bytes_per_s = 100};
  Radio radio = radio_of(spec);
  const std::vector<Pose2> places = {{0, 0, 0}, {2.9, 0, 0}, {0, -3.1, 0}, {0, 0, 0}};
  const auto fates = radio.send(0, std::string(200, 'm'), at(0), places);
  ASSERT_EQ(fates.size(), 2u);
  EXPECT_EQ(fates[0].second, RadioFate::on_its_way);
  EXPECT_EQ(fates[1].second, RadioFate::out_of_range);
  EXPECT_EQ(radio.send(0, "m", at(0.5), places)[0].second, RadioFate::queue_full);  // 1.5 s behind.
}

// 20,000 draws at a loss of 0.3: outside 4 sigma by chance once in 16,000 runs, and the seed is
// fixed.
TEST(Radio, LosesTheStatedShareIndependentlyForEachReceiver) {
  const RadioSpec spec{.loss = 0.3, .bytes_per_s = 1e9};
  Radio radio = radio_of(spec);
  const std::vector<Pose2> places(4);
  int lost_b = 0, lost_c = 0, lost_both = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const auto fates = radio.send(0, "m", at(i), places);
    const bool b = fates[0].second == RadioFate::lost, c = fates[1].second == RadioFate::lost;
    lost_b += b, lost_c += c, lost_both += b && c;
    radio.forget_before(at(i));
  }
  const double sigma = std::sqrt(0.3 * 0.7 / kDraws);
  EXPECT_NEAR(lost_b, 0.3 * kDraws, 4 * sigma * kDraws);
  EXPECT_NEAR(lost_c, 0.3 * kDraws, 4 * sigma * kDraws);
  EXPECT_NEAR(lost_both, 0.09 * kDraws, 4 * std::sqrt(0.09 * 0.91 / kDraws) * kDraws);
}

// Steps until the referee is in this state; false after 200 s.
bool wait_for(World& world, PlayState state) {
  for (int i = 0; i < 25000; ++i) {
    if (world.game_state(0, world.end()).state == state) return true;
    world.step();
  }
  return false;
}

TEST(Referee, LeadsThroughTwoHalvesToTheEnd) {
  World world(rules_match());
  const RefereeSpec& rules = world.scenario().referee;
  ASSERT_TRUE(wait_for(world, PlayState::ready));
  ASSERT_TRUE(wait_for(world, PlayState::set));
  EXPECT_NEAR(world.end().s(), rules.ready.s(), 0.02);
  ASSERT_TRUE(wait_for(world, PlayState::playing));
  EXPECT_TRUE(world.game_state(0, world.end()).first_half);
  EXPECT_EQ(world.game_state(0, world.end()).kick_off_team, Team::red);
  ASSERT_TRUE(wait_for(world, PlayState::ready));
  EXPECT_FALSE(world.game_state(0, world.end()).first_half);
  EXPECT_EQ(world.game_state(0, world.end()).kick_off_team, Team::blue);
  ASSERT_TRUE(wait_for(world, PlayState::finished));
  EXPECT_NEAR(world.end().s(), 2 * (rules.half.s() + rules.ready.s() + rules.set.s()), 0.1);
}

TEST(Referee, CountsAGoalForTheAttackersAndGivesTheOthersTheKickOff) {
  World world(rules_match());
  ASSERT_TRUE(wait_for(world, PlayState::playing));
  world.place_ball(2.0, 0.15, 2.0, 0);  // Past the keeper, into the sky-blue goal.
  world.place_robot(4, {1.5, 1.0, 3.14});
  ASSERT_TRUE(wait_for(world, PlayState::ready));
  EXPECT_EQ(world.score(Team::red), 1);
  EXPECT_EQ(world.score(Team::blue), 0);
  EXPECT_EQ(world.game_state(0, world.end()).own_score, 1);
  EXPECT_EQ(world.game_state(7, world.end()).opponent_score, 1);
  EXPECT_EQ(world.game_state(0, world.end()).kick_off_team, Team::blue);
  bool scored = false;
  for (const WorldEvent& event : world.take_events())
    scored |= event.kind == "goal" && event.detail == "red 1:0";
  EXPECT_TRUE(scored);
  ASSERT_TRUE(wait_for(world, PlayState::set));
  world.step();
  EXPECT_NEAR(world.ball(world.end()).p_W.x, 0, 1e-6);
}

TEST(Referee, HoldingTheBallTooLongCostsAPenalty) {
  Scenario s = rules_match();
  s.referee.stuck = SimDuration::from_s(1000);
  World world(s);
  ASSERT_TRUE(wait_for(world, PlayState::playing));
  world.place_robot(2, {-0.5, -0.8, 0});
  world.place_ball(-0.35, -0.8, 0, 0);
  RobotCommand grab;
  grab.kick = Kick::grab;
  world.apply(2, grab, world.end());
  const SimTime start = world.end();
  while (world.game_state(2, world.end()).penalty == Penalty::none &&
         (world.end() - start).s() < 10)
    world.step();
  EXPECT_NEAR((world.end() - start).s(), s.referee.holding.s(), 0.05);
  EXPECT_EQ(world.game_state(2, world.end()).penalty, Penalty::ball_holding);
  EXPECT_FALSE(world.robot(2, world.end()).on_field);
  EXPECT_LT(world.robot(2, world.end()).pose.y_m, -1.6);
  RobotCommand walk;
  walk.walk = BodyVelocity{0.2, 0, 0};
  world.apply(2, walk, world.end());
  const double y = world.robot(2, world.end()).pose.y_m;
  while (world.game_state(2, world.end()).penalty != Penalty::none &&
         (world.end() - start).s() < 60) {
    EXPECT_EQ(world.robot(2, world.end()).pose.y_m, y);  // Penalised robots do not walk.
    world.step();
  }
  EXPECT_NEAR((world.end() - start).s(), s.referee.holding.s() + s.referee.penalty.s(), 0.1);
  EXPECT_TRUE(world.robot(2, world.end()).on_field);
}

TEST(Play, GrabbedBallMovesWithTheRobotAndAKickSendsItAhead) {
  Scenario s = rules_match();
  s.referee.enabled = false;
  s.robots.resize(1);
  s.robots[0].pose = {0, 0, 0};
  s.ball.x_m = 0.155;
  World world(s);
  RobotCommand command;
  command.kick = Kick::grab;
  command.walk = BodyVelocity{0.1, 0, 0.5};
  world.apply(0, command, SimTime());
  for (int i = 0; i < 200; ++i) world.step();
  const Pose2 pose = world.robot(0, world.end()).pose;
  const Vec3 ball = world.ball(world.end()).p_W;
  EXPECT_GT(pose.theta_rad, 0.5);
  EXPECT_NEAR(std::hypot(ball.x - pose.x_m, ball.y - pose.y_m), s.robots[0].body.hold_x_m, 0.003);
  command = {};
  command.kick = Kick::leg_forward;
  world.apply(0, command, world.end());
  for (int i = 0; i < 60; ++i) world.step();
  const BallTruth kicked = world.ball(world.end());
  const double speed = std::hypot(kicked.v_W.x, kicked.v_W.y);
  EXPECT_GT(speed, 0.7);
  EXPECT_NEAR(std::atan2(kicked.v_W.y, kicked.v_W.x), pose.theta_rad, 0.4);
}

TEST(Play, ALegThatSwingsAgainstTheBallPushesIt) {
  Scenario s = rules_match();
  s.referee.enabled = false;
  s.robots.resize(1);
  s.robots[0].pose = {0, 0, 0};
  s.ball.x_m = 0.165, s.ball.y_m = 0.0625;
  World world(s);
  RobotCommand command;
  command.joints = {{SimDuration(), {{kLeftFrontRotator, 1.2, 0}, {kLeftFrontKnee, 0.2, 0}}}};
  world.apply(0, command, SimTime());
  for (int i = 0; i < 120; ++i) world.step();
  EXPECT_GT(world.ball(world.end()).p_W.x, 0.19);
}

TEST(Sensors, ReadingsKeepTheirClockLatencyAndNoise) {
  Scenario s = rules_match();
  s.robots.resize(1);
  s.referee.enabled = false;
  s.robots[0].sensors.joints = {SimDuration::from_s(0.008), SimDuration(),
                                SimDuration::from_s(0.004), 0.01};
  s.robots[0].sensors.accelerometer = {SimDuration::from_s(0.01), SimDuration::from_s(0.002),
                                       SimDuration(), 0.3};
  World world(s);
  double sum = 0, squares = 0, gravity = 0;
  int count = 0;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    const SimTime now = world.start() + SimDuration::from_s(0.003);
    const RobotSensors sensors = world.sensors(0, now, now - SimDuration::from_s(0.032));
    if (i < 5) continue;
    EXPECT_EQ(sensors.joints.time,
              world.start() - SimDuration::from_s(0.008));  // Newest with 4 ms latency.
    EXPECT_EQ(sensors.joint_log.size(), 4u);
    EXPECT_EQ(sensors.acceleration_time.ns() % 10'000'000, 2'000'000);
    EXPECT_LT((now - sensors.acceleration_time).ns(), 10'000'000);
    const double noise = sensors.joints.rad[kPan];
    sum += noise, squares += noise * noise, ++count;
    gravity += sensors.acceleration_m_s2.z;
  }
  // 1995 readings: 4 sigma of mean and standard deviation.
  EXPECT_NEAR(sum / count, 0, 4 * 0.01 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.01, 4 * 0.01 / std::sqrt(2.0 * count));
  EXPECT_NEAR(gravity / count, 9.81, 4 * 0.3 / std::sqrt(0.8 * count));
}

// Turn by turn, its readings add up to where the body has turned, on its paws as on the ground.
TEST(Sensors, AGyroscopesReadingsAddUpToTheTurn) {
  Scenario s = rules_match();
  s.robots.resize(1);
  s.referee.enabled = false;
  s.robots[0].sensors.gyroscope = SensorSpec{.period = s.step};
  World world(s);
  RobotCommand command;
  command.walk = BodyVelocity{0.1, 0.02, 0.9};
  world.apply(0, command, SimTime());
  for (int i = 0; i < 50; ++i) world.step();
  const Mat3 before = world.robot(0, world.end()).X_WB.R;
  Mat3 added(1.0);
  double most_tilting = 0;
  for (int i = 0; i < 100; ++i) {
    world.step();
    const RobotSensors seen = world.sensors(0, world.end(), world.start());
    EXPECT_EQ(seen.angular_velocity_time, world.end());
    const Vec3 rate = seen.angular_velocity_rad_s.value();
    const double size = glm::length(rate);
    added = added * rotation_about(rate / size, size * s.step.s());
    most_tilting = std::max(most_tilting, maths::length(rate.x, rate.y));
  }
  const Mat3 expected = glm::transpose(before) * world.robot(0, world.end()).X_WB.R;
  for (int i = 0; i < 3; ++i) EXPECT_LT(glm::length(added[i] - expected[i]), 1e-11) << i;
  EXPECT_GT(most_tilting, 0.1);                      // It sways as it walks,
  EXPECT_NEAR(expected[0].y, std::sin(0.72), 0.05);  // and turns by 0.9 rad/s in 0.8 s.
}

TEST(Sensors, ARobotHasAGyroscopeWhereTheScenarioNamesOne) {
  const std::string text =
      "format: seam-scenario/1\nduration_s: 1\nrobot_defaults:\n  body: " + kRulesSource +
      "/models/robot_ers210.yaml\n  sensors: {gyroscope: {period_s: 0.016, sigma: 0.3}}\n"
      "robots:\n  - {id: a, team: red, pose: {x_m: 0, y_m: 0}}\n"
      "  - {id: b, team: red, pose: {x_m: 1, y_m: 0}, sensors: {gyroscope: {present: false}}}\n";
  const Scenario s = Scenario::from_text(text, "scenario");
  EXPECT_EQ(Scenario::from_text(s.to_yaml(), "copy").to_yaml(), s.to_yaml());
  World world(s);
  double squares = 0;
  constexpr int kReadings = 1000;
  for (int i = 0; i < 2 * kReadings; ++i) {
    world.step();
    const RobotSensors seen = world.sensors(0, world.end(), world.start());
    EXPECT_EQ(seen.angular_velocity_time.ns() % 16'000'000, 0);
    if (i % 2 == 0) squares += glm::dot(*seen.angular_velocity_rad_s, *seen.angular_velocity_rad_s);
    EXPECT_FALSE(world.sensors(1, world.end(), world.start()).angular_velocity_rad_s);
  }
  EXPECT_NEAR(std::sqrt(squares / (3 * kReadings)), 0.3, 4 * 0.3 / std::sqrt(6.0 * kReadings));
  // What others have in their states and logs stays as it was without gyroscopes.
  for (const StateSection& section : world.sections()) {
    for (const StateSection::Field& field : section.fields)
      EXPECT_EQ(field.name.find("angular_velocity") != std::string::npos,
                section.name.find("/a") != std::string::npos &&
                    field.name.starts_with("angular_velocity"))
          << section.name << " " << field.name;
  }
}

TEST(Sensors, AskingNeverChangesTheWorld) {
  World world(rules_match());
  for (int i = 0; i < 10; ++i) world.step();
  const uint64_t before = world.hash();
  const SimTime now = world.start() + SimDuration::from_s(0.0051);
  const RobotSensors once = world.sensors(3, now, SimTime()),
                     twice = world.sensors(3, now, SimTime());
  EXPECT_EQ(once.joints.rad, twice.joints.rad);
  EXPECT_EQ(world.hash(), before);
}

TEST(Commands, BadOnesAreNamed) {
  RobotCommand command;
  EXPECT_FALSE(invalid_field(command));
  command.walk = BodyVelocity{0.1, std::nan(""), 0};
  EXPECT_EQ(invalid_field(command).value_or(""),
            "walk.vy_mps: found nan, expected a number from -10 to 10");
  command.walk.reset();
  command.joints = {{SimDuration(), {{kPan, 0, 0}}}, {SimDuration::from_ns(-1), {}}};
  EXPECT_EQ(invalid_field(command).value_or("").substr(0, 16), "joints[1].offset");
  command.joints = {{SimDuration(), {{kMostJoints, 0, 0}}}};
  EXPECT_EQ(invalid_field(command).value_or("").substr(0, 26), "joints[0].targets[0].joint");
}

}  // namespace
}  // namespace seam
