#include "sim_core/world/world.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"

namespace seam {
namespace {

const std::string kSource = SEAM_SOURCE_DIR;

// Eight robots on the field without behaviours.
Scenario match() {
  Scenario s = Scenario::from_file(kSource + "/scenarios/match.yaml");
  s.referee.enabled = false;
  return s;
}

// What robot `i` is commanded at step `k`: walks, head and leg targets and kicks, drawn at random.
RobotCommand random_command(uint64_t robot, uint64_t k) {
  const RandomStream t = RandomStream{99, 0}.child(robot).child(k);
  RobotCommand command;
  command.walk =
      BodyVelocity{0.5 * uniform(t, 0) - 0.2, 0.2 * uniform(t, 1) - 0.1, 2 * uniform(t, 2) - 1};
  command.joints = {
      {SimDuration(), {{kPan, 3 * uniform(t, 3) - 1.5, 0}, {kTilt, uniform(t, 4) - 1, 0}}},
      {SimDuration::from_ns(8'000'000), {{kPan, 3 * uniform(t, 5) - 1.5, 2}}}};
  if (uniform(t, 6) < 0.2)
    command.kick = static_cast<Kick>(1 + static_cast<int>(7 * uniform(t, 7)));
  if (uniform(t, 8) < 0.1)
    command.joints[0].targets.push_back({kLeftFrontRotator, uniform(t, 9), 0});
  return command;
}

// Steps `from` to `to` - 1; commands every 4 steps, half a millisecond after the step; radio, too.
void play(World& world, uint64_t from, uint64_t to) {
  for (uint64_t k = from; k < to; ++k) {
    world.step();
    if (k % 4 != 0) continue;
    const SimTime time = world.start() + SimDuration::from_ns(500'000);
    for (size_t i = 0; i < world.scenario().robots.size(); ++i) {
      world.apply(i, random_command(i, k), time);
      world.send_radio(i, "hello", time);
    }
  }
}

TEST(World, SameCommandsGiveSameBits) {
  World a(match()), b(match());
  for (uint64_t k = 0; k < 300; k += 50) {
    play(a, k, k + 50);
    play(b, k, k + 50);
    ASSERT_EQ(a.digest().section_hashes, b.digest().section_hashes)
        << first_difference(a.sections(), b.sections()).field;
  }
}

// Pinned for every compiler, optimisation and machine; a change of results that was meant changes
// it.
TEST(World, OthersSensorsChangeNothingForTheRobotThatIsSensed) {
  World all(match()), one(match());
  one.sense_only(1);
  play(all, 0, 200);
  play(one, 0, 200);
  const SimTime now = all.end(), since = now - SimDuration::from_s(0.032);
  const RobotSensors expected = all.sensors(1, now, since), seen = one.sensors(1, now, since);
  ASSERT_FALSE(expected.joint_log.empty());
  EXPECT_EQ(seen.joint_log.size(), expected.joint_log.size());
  EXPECT_EQ(seen.joints.rad, expected.joints.rad);
  EXPECT_EQ(seen.odometry.x_m, expected.odometry.x_m);
  EXPECT_EQ(seen.acceleration_m_s2, expected.acceleration_m_s2);
  EXPECT_TRUE(one.sensors(0, now, since).joint_log.empty());
}

TEST(World, StateHashIsTheGoldenOne) {
  World world(match());
  play(world, 0, 250);
  EXPECT_EQ(to_hex(world.hash()), "1594c9df9cec1ef5");
}

TEST(World, RunFromASnapshotEqualsTheUninterruptedRun) {
  Scenario scenario = match();
  scenario.robots[1].sensors.gyroscope = SensorSpec{.latency = SimDuration::from_s(0.02)};
  World whole(scenario);
  play(whole, 0, 301);
  const std::string snapshot = whole.snapshot();
  World resumed(scenario);
  play(resumed, 0, 17);  // Whatever it did before must not matter.
  resumed.restore(snapshot);
  for (uint64_t k = 301; k < 926; ++k) {  // 5 s.
    play(whole, k, k + 1);
    play(resumed, k, k + 1);
    const StateDifference difference = whole.hash() == resumed.hash()
                                           ? StateDifference{}
                                           : first_difference(whole.sections(), resumed.sections());
    ASSERT_FALSE(difference.found) << k << " " << difference.section << " " << difference.field;
  }
  EXPECT_EQ(whole.snapshot(), resumed.snapshot());
}

TEST(World, DamagedSnapshotsAreRefused) {
  World world(match());
  play(world, 0, 10);
  const std::string snapshot = world.snapshot();
  World other(match());
  EXPECT_THROW(other.restore(snapshot.substr(0, snapshot.size() - 8)), InputError);
  EXPECT_THROW(other.restore(snapshot + std::string(8, '\0')), InputError);
  EXPECT_THROW(other.restore(std::string(snapshot.size(), '\xff')), InputError);
}

TEST(World, SectionHashesAreThoseOfTheListedFields) {
  World world(match());
  play(world, 0, 10);
  const auto sections = world.sections();
  const auto hashes = world.digest().section_hashes;
  const auto names = world.section_names();
  ASSERT_EQ(sections.size(), hashes.size());
  for (size_t i = 0; i < sections.size(); ++i) {
    EXPECT_EQ(sections[i].hash(), hashes[i]) << names[i];
    EXPECT_EQ(sections[i].name, names[i]);
  }
}

TEST(World, OneChangedCommandShowsInItsRobotFirst) {
  World a(match()), b(match());
  play(a, 0, 4);
  play(b, 0, 4);
  RobotCommand command;
  command.joints = {{SimDuration(), {{kPan, 0.5, 0}}}};
  a.apply(2, command, a.start());
  command.joints[0].targets[0].angle_rad = std::nextafter(0.5, 1);
  b.apply(2, command, b.start());
  const StateDifference difference = first_difference(a.sections(), b.sections());
  EXPECT_EQ(difference.section, "robot/" + a.scenario().robots[2].id);
  EXPECT_EQ(difference.field, "pan.to_rad");
}

TEST(World, StateIsContinuousAcrossSteps) {
  World world(match());
  for (int k = 0; k < 200; ++k) {
    std::vector<Primitive> before, after;
    play(world, static_cast<uint64_t>(k), static_cast<uint64_t>(k) + 1);
    world.primitives_at(world.end(), before);
    World next(match());
    next.restore(world.snapshot());
    next.step();
    next.primitives_at(next.start(), after);
    ASSERT_EQ(before.size(), after.size());
    for (size_t i = 0; i < before.size(); ++i) {
      ASSERT_LT(glm::length(before[i].X_WO.p - after[i].X_WO.p), 1e-9) << k << " part " << i;
    }
  }
}

// Moves in any step by no more than legs, joints and the fastest ball can.
TEST(World, NothingJumps) {
  World world(match());
  std::vector<Primitive> before, after;
  world.primitives_at(SimTime(), before);
  for (uint64_t k = 0; k < 400; ++k) {
    play(world, k, k + 1);
    after.clear();
    world.primitives_at(world.end(), after);
    for (size_t i = 0; i < after.size(); ++i) {
      ASSERT_LT(glm::length(before[i].X_WO.p - after[i].X_WO.p), 3.0 * 0.008) << k << " part " << i;
    }
    before.swap(after);
  }
}

TEST(World, RobotsAndBallStayInsideTheWallsAndApart) {
  World world(match());
  for (uint64_t k = 0; k < 1000; ++k) {
    play(world, k, k + 1);
    const Vec3 ball = world.ball(world.end()).p_W;
    ASSERT_LT(std::abs(ball.x), (std::abs(ball.y) < 0.3 ? 2.4 : 2.1) - 0.04) << k;
    ASSERT_LT(std::abs(ball.y), 1.35 - 0.04) << k;
    for (size_t i = 0; i < 8; ++i) {
      const Pose2 a = world.robot(i, world.end()).pose;
      const bool in_goal = std::abs(a.y_m) < 0.3;
      ASSERT_LT(std::abs(a.x_m), in_goal ? 2.4 : 2.1);
      ASSERT_LT(std::abs(a.y_m), 1.35 - 0.07);
      for (size_t j = 0; j < i; ++j) {
        const Pose2 b = world.robot(j, world.end()).pose;
        ASSERT_GT(std::hypot(a.x_m - b.x_m, a.y_m - b.y_m), 0.13) << k << ": " << i << " and " << j;
      }
    }
  }
}

TEST(World, WalksAsCommandedOnAnArc) {
  Scenario s = match();
  s.robots.resize(1);
  s.has_field = false;
  s.ball.present = false;
  s.robots[0].pose = {0, 0, 0.3};
  s.robots[0].sensors.odometry.sigma = 0;
  World world(s);
  RobotCommand command;
  command.walk = BodyVelocity{0.2, 0.05, 0.8};
  world.apply(0, command, SimTime());
  for (int i = 0; i < 500; ++i) world.step();  // 4 s.
  const double turn = 0.8 * 4, radius_v = 0.2 / 0.8, radius_w = 0.05 / 0.8;
  const double x = radius_v * std::sin(turn) + radius_w * (std::cos(turn) - 1);
  const double y = radius_v * (1 - std::cos(turn)) + radius_w * std::sin(turn);
  const Pose2 pose = world.robot(0, world.end()).pose;
  EXPECT_NEAR(pose.x_m, std::cos(0.3) * x - std::sin(0.3) * y, 2e-5);
  EXPECT_NEAR(pose.y_m, std::sin(0.3) * x + std::cos(0.3) * y, 2e-5);
  const RobotSensors sensors = world.sensors(0, world.end(), SimTime());
  EXPECT_NEAR(sensors.odometry.x_m, x, 1e-9);
  EXPECT_NEAR(sensors.odometry.y_m, y, 1e-9);
}

TEST(World, HeadTurnsAtItsSpeedLimitAsAnExactFunctionOfTime) {
  Scenario s = match();
  World world(s);
  RobotCommand command;
  command.joints = {{SimDuration(), {{kPan, 1.0, 0}}}};
  const SimTime start = SimTime::from_ns(3'000'001);
  world.step();
  world.apply(0, command, start);
  for (int i = 0; i < 20; ++i) {
    const SimTime time = SimTime::from_ns(world.end().ns() - 1'234'567);
    EXPECT_DOUBLE_EQ(world.robot(0, time).joints_rad[kPan],
                     std::min(1.0, 3.010693 * (time - start).s()));
    world.step();
  }
}

TEST(World, FrozenRobotStandsStill) {
  World world(match());
  play(world, 0, 50);
  world.freeze(3, world.end());
  for (int i = 0; i < 60; ++i) world.step();  // Strides fade.
  const RobotTruth before = world.robot(3, world.end());
  world.step();
  const RobotTruth after = world.robot(3, world.end());
  EXPECT_EQ(before.joints_rad[kPan], after.joints_rad[kPan]);
  EXPECT_NEAR(before.pose.x_m, after.pose.x_m, 1e-9);
}

TEST(World, WalkingShakesTheCameraAndStandingDoesNot) {
  const auto spread_of = [](double vx) {
    Scenario s = match();
    s.robots.resize(1);
    World world(s);
    RobotCommand command;
    command.walk = BodyVelocity{vx, 0, 0};
    world.apply(0, command, SimTime());
    double low = 1, high = 0;
    for (int i = 0; i < 300; ++i) {
      world.step();
      if (i < 100) continue;
      const double z = world.camera_link_pose(0, world.end()).p.z;
      low = std::min(low, z), high = std::max(high, z);
    }
    return high - low;
  };
  EXPECT_LT(spread_of(0), 1e-12);
  EXPECT_GT(spread_of(0.2), 0.002);
  EXPECT_LT(spread_of(0.2), 0.05);
}

}  // namespace
}  // namespace seam
