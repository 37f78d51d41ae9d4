// Two runs held against each other, recovery, and frames made after the fact.
#include "scheduler/replay/log_diff.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scheduler/log/log_recovery.h"
#include "scheduler/replay/frame_maker.h"
#include "scheduler/replay/log_testing.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace seam::scheduler::testing;

std::string three_robots(double duration_s = 2) {
  return scenario_text(SEAM_SOURCE_DIR, 3, duration_s);
}

StateAt state_of(const Log& log, World& world, std::optional<Rewinder>& rewinder) {
  rewinder.emplace(log, world);
  return [&](SimTime time) {
    rewinder->to(time);
    return world.sections();
  };
}

TEST(LogDiff, OfALogAndItselfIsNothing) {
  const RecordedRun run = record(three_robots());
  const Log a = log_of(run.bytes), b = log_of(run.bytes);
  const LogDifference difference = compare_logs(a, b);
  EXPECT_TRUE(difference.equal());
  EXPECT_EQ(difference.compared_until, SimTime::from_s(2));
}

TEST(LogDiff, NamesTheFirstDifferenceItsCauseAndItsSpread) {
  const RecordedRun run_a = record(three_robots());
  FunctionSource changed([](const Observation& seen) {
    Decision decision = busy_behaviour(seen);
    if (seen.robot == 1 && seen.sequence == 20)
      decision.command.joints[0].targets[0].angle_rad = 0.1;
    return decision;
  });
  const RecordedRun run_b = record(three_robots(), changed);
  const Log a = log_of(run_a.bytes), b = log_of(run_b.bytes);
  LogDifference difference = compare_logs(a, b);
  EXPECT_FALSE(difference.equal());
  EXPECT_TRUE(difference.header.empty());
  ASSERT_TRUE(difference.first_decision);
  EXPECT_EQ(difference.first_decision->robot, "r1");
  ASSERT_TRUE(difference.first);
  EXPECT_EQ(difference.first->section, "robot/r1");
  EXPECT_GT(difference.first->time, difference.first_decision->time);

  const Scenario scenario = Scenario::from_text(a.header().scenario_text, "a");
  World world_a(scenario), world_b(scenario);
  std::optional<Rewinder> rewinder_a, rewinder_b;
  name_field(difference, state_of(a, world_a, rewinder_a), state_of(b, world_b, rewinder_b));
  EXPECT_THAT(difference.first->field, HasSubstr("pan"));
  EXPECT_NE(difference.first->a, difference.first->b);

  std::vector<std::string> spread;
  for (const auto& step : difference.spread) spread.push_back(step.section);
  EXPECT_THAT(spread, ::testing::Contains("frame/r1"));
  EXPECT_THAT(spread, ::testing::Not(::testing::Contains("robot/r0")));
}

TEST(LogDiff, HandlesOtherLengthsSeedsAndRobots) {
  const RecordedRun two = record(three_robots(2));
  const RecordedRun one = record(three_robots(1));
  const LogDifference lengths = compare_logs(log_of(two.bytes), log_of(one.bytes));
  EXPECT_TRUE(lengths.spread.empty());
  EXPECT_FALSE(lengths.equal());
  EXPECT_EQ(lengths.compared_until, SimTime::from_s(1));
  EXPECT_GE(lengths.end_a, SimTime::from_s(2));

  const RecordedRun more = record(scenario_text(SEAM_SOURCE_DIR, 4, 1));
  const LogDifference robots = compare_logs(log_of(one.bytes), log_of(more.bytes));
  EXPECT_THAT(robots.header, ::testing::Contains(HasSubstr("robots")));
  // A robot that only one run has is named there, not as frames that are missing.
  for (const auto& spread : robots.spread) EXPECT_NE(spread.section, "frame/r3");

  std::string yaml = three_robots(1);
  yaml.replace(yaml.find("seed: 7"), 7, "seed: 8");
  const LogDifference seeds = compare_logs(log_of(one.bytes), log_of(record(yaml).bytes));
  EXPECT_THAT(seeds.header, ::testing::Contains("seed: 7 and 8"));
}

TEST(LogDiff, NamesTheKeysInWhichScenariosOfOneNameDiffer) {
  const std::string yaml = three_robots(1);
  const auto lit = [&](const char* direction) {
    return log_of(record(yaml + "lighting: {lambert: true, direction: " + direction + "}\n").bytes);
  };
  const LogDifference difference = compare_logs(lit("[0.3, 0.1, 0.95]"), lit("[0.3, 0.1, 0.951]"));
  EXPECT_THAT(difference.header,
              ::testing::Contains(::testing::AllOf(HasSubstr("lighting.direction"),
                                                   ::testing::Not(HasSubstr("lambert")))));
}

TEST(LogRecovery, OfAWholeLogLosesNothing) {
  const RecordedRun run = record(three_robots());
  mcap::MemoryOutput output;
  const Recovery recovery = recover_log(std::make_unique<mcap::MemoryInput>(run.bytes), output);
  EXPECT_TRUE(recovery.whole());
  EXPECT_FALSE(verify(log_of(output.bytes())).divergence);
}

TEST(LogRecovery, OfAKilledRunIsAWholeLogThatReRuns) {
  FunctionSource source(busy_behaviour);
  const RecordedRun run = record(three_robots(), source, {}, SimTime::from_s(1.6));
  mcap::MemoryOutput output;
  const Recovery recovery = recover_log(std::make_unique<mcap::MemoryInput>(run.bytes), output);
  EXPECT_FALSE(recovery.whole());
  const Log log = log_of(output.bytes());
  EXPECT_TRUE(log.file().contents().complete);
  EXPECT_GE(log.end_time(), SimTime::from_s(0.6));
  EXPECT_FALSE(verify(log).divergence);
}

TEST(LogRecovery, KeepsWhatStandsBehindDamage) {
  const RecordedRun run = record(three_robots(3));
  const Log whole = log_of(run.bytes);
  const auto& chunks = whole.file().contents().chunks;
  ASSERT_GE(chunks.size(), 5u);
  for (const size_t damaged : {size_t{0}, chunks.size() / 2}) {
    std::string bytes = run.bytes;
    bytes[chunks[damaged].offset + 200] ^= 0x10;
    mcap::MemoryOutput output;
    const Recovery recovery = recover_log(std::make_unique<mcap::MemoryInput>(bytes), output);
    EXPECT_EQ(recovery.chunks, chunks.size() - 1);
    ASSERT_EQ(recovery.losses.size(), 1u);
    const Log log = log_of(output.bytes());
    EXPECT_EQ(log.header().seed, 7u);
    EXPECT_EQ(log.end_time(), whole.end_time());
  }
}

TEST(LogRecovery, SaysWhatStandsBehindTheEnd) {
  const std::string first = record(three_robots()).bytes;
  mcap::MemoryOutput alone;
  recover_log(std::make_unique<mcap::MemoryInput>(first), alone);
  for (const std::string& behind : {first, std::string("some bytes")}) {
    mcap::MemoryOutput output;
    const Recovery recovery =
        recover_log(std::make_unique<mcap::MemoryInput>(first + behind), output);
    EXPECT_FALSE(recovery.whole());
    EXPECT_TRUE(recovery.losses.empty());
    ASSERT_TRUE(recovery.behind_end);
    EXPECT_EQ(recovery.behind_end->offset, first.size());
    EXPECT_EQ(recovery.behind_end->bytes, behind.size());
    EXPECT_EQ(output.bytes(), alone.bytes());
    EXPECT_EQ(log_of(first + behind, LogAccess::scanned).losses().size(), 1u);
  }
}

TEST(LogRecovery, OfNothingIsAnError) {
  mcap::MemoryOutput output;
  EXPECT_THROW(recover_log(std::make_unique<mcap::MemoryInput>("no log"), output), InputError);
}

TEST(FrameMaker, MakesTheFramesThatTheRunMade) {
  const RecordedRun run =
      record(three_robots(), {.snapshot_period = SimDuration::from_ns(400'000'000)});
  const Log log = log_of(run.bytes);
  const Scenario scenario = Scenario::from_text(log.header().scenario_text, "log");
  World world(scenario);
  HashRenderer renderer(scenario);
  Rewinder rewinder(log, world);
  std::map<uint64_t, uint64_t> made;  // Fingerprint by index.
  make_frames(rewinder, renderer, 1, SimTime::from_s(0.5), SimTime::from_s(1.5),
              [&](const FinishedFrame& frame) {
                made[frame.frame->frame_index] = frame.frame->fingerprint;
                EXPECT_EQ(frame.job->row_cameras.size(), 8u);
              });
  EXPECT_EQ(made.size(), 25u);
  LogCursor cursor(log, {Topic::frame});
  size_t compared = 0;
  while (const auto record = cursor.next()) {
    const FrameRecord& frame = std::get<FrameRecord>(*record);
    if (frame.robot != 1 || !made.contains(frame.index)) continue;
    EXPECT_EQ(made[frame.index], frame.fingerprint) << frame.index;
    ++compared;
  }
  EXPECT_EQ(compared, 25u);
}

}  // namespace
}  // namespace seam::scheduler
