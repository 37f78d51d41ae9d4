// A log re-runs to the same bits, and says where it does not.
#include "scheduler/log/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <tuple>

#include "scheduler/log/log_recovery.h"
#include "scheduler/replay/log_testing.h"
#include "sim_core/base/error.h"
#include "sim_core/base/random.h"

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace seam::scheduler::testing;

std::string text(double duration_s = 2, const std::string& behaviour_extra = "") {
  return scenario_text(SEAM_SOURCE_DIR, 3, duration_s, 32, behaviour_extra);
}

// The same log with each record of `topic` changed by `edit`, which returns whether it is kept.
std::string rewritten(const std::string& bytes, Topic wanted,
                      const std::function<bool(LogRecord&)>& edit) {
  const std::vector<std::string> robots = log_of(bytes).header().robots;
  return edited(bytes, {.message = [&](CopiedMessage& message) {
                  if (message.topic != topic_name(wanted)) return true;
                  LogRecord record = decode(wanted, message.data, robots);
                  if (!edit(record)) return false;
                  message.data = encode(record, robots);
                  return true;
                }});
}

TEST(Log, ReRunsToTheSameBits) {
  const RecordedRun run = record(text());
  const Log log = log_of(run.bytes);
  EXPECT_EQ(log.header().seed, 7u);
  EXPECT_EQ(log.header().robots, (std::vector<std::string>{"r0", "r1", "r2"}));
  ASSERT_TRUE(log.end());
  EXPECT_EQ(log.end()->fingerprint, run.fingerprint);
  EXPECT_TRUE(log.losses().empty());
  const Verification verified = verify(log);
  EXPECT_FALSE(verified.divergence) << verified.divergence->section << verified.divergence->detail;
  EXPECT_EQ(verified.steps, log.end()->steps);
  EXPECT_EQ(verified.frames, log.end()->frames);
  EXPECT_GT(verified.frames, 100u);
  EXPECT_FALSE(verify(log, false).divergence);
}

TEST(Log, IsTheSameFileEachTime) {
  EXPECT_EQ(record(text()).bytes, record(text()).bytes);
}

TEST(Log, NamesTimeSectionAndFieldOfABrokenCommand) {
  const RecordedRun run = record(text(2, ", decision_latency_s: 0.01"));
  SimTime broken_at;
  int number = 0;
  const std::string broken = rewritten(run.bytes, Topic::turn, [&](LogRecord& record) {
    auto& turn = std::get<TurnRecord>(record);
    for (Answer& answer : turn.turn.answers) {
      if (answer.robot != 1 || ++number != 20) continue;
      auto bits = std::bit_cast<uint64_t>(answer.decision.command.joints[0].targets[0].angle_rad);
      answer.decision.command.joints[0].targets[0].angle_rad = std::bit_cast<double>(bits ^ 0xFF);
      broken_at = turn.time;
    }
    return true;
  });
  ASSERT_GT(broken_at, SimTime());
  const Verification verified = verify(log_of(broken));
  ASSERT_TRUE(verified.divergence);
  EXPECT_EQ(verified.divergence->section, "robot/r1");
  EXPECT_THAT(verified.divergence->field, HasSubstr("pan"));
  EXPECT_GE(verified.divergence->time, broken_at);
  EXPECT_LE(verified.divergence->time, broken_at + SimDuration::from_ns(24'000'000));
}

TEST(Log, NamesAFrameWithOtherPixels) {
  const RecordedRun run = record(text());
  int number = 0;
  SimTime time;
  const std::string broken = rewritten(run.bytes, Topic::frame, [&](LogRecord& record) {
    if (++number == 30) {
      std::get<FrameRecord>(record).fingerprint ^= 1;
      time = std::get<FrameRecord>(record).time;
    }
    return true;
  });
  const Verification verified = verify(log_of(broken));
  ASSERT_TRUE(verified.divergence);
  EXPECT_THAT(verified.divergence->section, HasSubstr("frame/r"));
  EXPECT_EQ(verified.divergence->field, "pixels");
  EXPECT_EQ(verified.divergence->time, time);
}

TEST(Log, AMissingStepIsADivergence) {
  const RecordedRun run = record(text());
  const std::string broken = rewritten(run.bytes, Topic::step, [&](LogRecord& record) {
    return std::get<StepRecord>(record).step != 100;
  });
  const Verification verified = verify(log_of(broken));
  ASSERT_TRUE(verified.divergence);
  EXPECT_EQ(verified.divergence->field, "step");
}

TEST(Log, AMissingTurnSaysSo) {
  const RecordedRun run = record(text());
  int number = 0;
  const std::string broken =
      rewritten(run.bytes, Topic::turn, [&](LogRecord&) { return ++number != 50; });
  EXPECT_THROW(verify(log_of(broken)), InputError);
}

TEST(Log, CheckBitsNameAFieldWhereTheSumsAreSilent) {
  const RecordedRun run = record(text());
  bool is_changed = false;
  const std::string broken = rewritten(run.bytes, Topic::step, [&](LogRecord& record) {
    auto& step = std::get<StepRecord>(record);
    if (step.step < 100) return true;
    step.fingerprint ^= 1;
    step.section_hashes.at(0) ^= 1;
    step.field_sums.at(0) ^= 0x1234567;  // No three fields give this.
    if (!step.field_checks.empty()) {
      step.field_checks.at(0) =
          static_cast<char>(step.field_checks.at(0) ^ 0x04);  // The second field.
      is_changed = true;
    }
    return true;
  });
  ASSERT_TRUE(is_changed);
  const Log log = log_of(broken);
  const Verification verified = verify(log);
  ASSERT_TRUE(verified.divergence);
  EXPECT_EQ(verified.divergence->section, log.header().sections.at(0));
  const World world(Scenario::from_text(log.header().scenario_text, "log"));
  EXPECT_EQ(verified.divergence->field, world.sections().at(0).fields.at(1).name);
}

TEST(Log, OlderLogsWithoutChecksSnapshotsAndPosesStillVerify) {
  RecordedRun run = record(text());
  std::string older = rewritten(run.bytes, Topic::step, [&](LogRecord& record) {
    std::get<StepRecord>(record).field_checks.clear();
    std::get<StepRecord>(record).field_sums.clear();
    std::get<StepRecord>(record).poses.clear();
    return true;
  });
  older = rewritten(older, Topic::snapshot, [](LogRecord&) { return false; });
  EXPECT_FALSE(verify(log_of(older)).divergence);
}

TEST(Log, OfAKilledRunVerifiesAsFarAsItGoes) {
  FunctionSource source(busy_behaviour);
  const RecordedRun run = record(text(), source, {}, SimTime::from_s(1.7));
  const Log log = log_of(run.bytes);
  EXPECT_FALSE(log.end());
  EXPECT_GE(log.end_time(), SimTime::from_s(0.7));
  const Verification verified = verify(log);
  EXPECT_FALSE(verified.divergence) << verified.divergence->detail;
  EXPECT_GT(verified.steps, 80u);
}

TEST(Log, GoesOnFromAKilledRunToTheSameFingerprint) {
  const RecordedRun whole = record(text());
  for (const double killed_s : {0.3, 0.777, 1.5, 1.99}) {
    FunctionSource first(busy_behaviour);
    const RecordedRun killed = record(text(), first, {}, SimTime::from_s(killed_s));
    const Log log = log_of(killed.bytes);
    FunctionSource live(busy_behaviour);
    MixedReport report;
    MixedSource mixed(log, live, report);
    const RecordedRun resumed = record(text(), mixed);
    EXPECT_EQ(resumed.fingerprint, whole.fingerprint);
    EXPECT_EQ(resumed.bytes, whole.bytes);
    EXPECT_EQ(report.different_decisions, 0u);
    // The last second may not have reached the log.
    if (killed_s > 1) {
      EXPECT_GT(report.compared_decisions, 0u);
    }
    EXPECT_TRUE(report.live_since);
  }
}

TEST(Log, ChangesOneRobotFromAMomentOn) {
  const RecordedRun whole = record(text());
  const Log log = log_of(whole.bytes);
  FunctionSource live([](const Observation& seen) {
    Decision decision = busy_behaviour(seen);
    if (seen.robot == 1) decision.command.walk = BodyVelocity{0.3, 0, 0};
    return decision;
  });
  MixedReport report;
  MixedSource mixed(log, live, report, {.live_robots = {1}, .live_from = SimTime::from_s(1)});
  const RecordedRun changed = record(text(), mixed);
  EXPECT_NE(changed.fingerprint, whole.fingerprint);
  const Log other = log_of(changed.bytes);
  for (const double time_s : {0.9, 1.9}) {
    const auto a = log.step_before(SimTime::from_s(time_s));
    const auto b = other.step_before(SimTime::from_s(time_s));
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->step, b->step);
    EXPECT_EQ(a->fingerprint == b->fingerprint, time_s < 1) << time_s;
  }
}

TEST(Log, RewindsToAnyTime) {
  for (const char* extra : {"", ", decision_latency_s: 0.05"}) {
    const RecordedRun run =
        record(text(2, extra), {.snapshot_period = SimDuration::from_ns(300'000'000)});
    const Log log = log_of(run.bytes);
    const Scenario scenario = Scenario::from_text(log.header().scenario_text, "log");
    World world(scenario);
    Rewinder rewinder(log, world);
    for (const double time_s : {1.0, 0.2, 1.999, 1.234, 0.0, 1.235, 0.601}) {
      const SimTime time = SimTime::from_s(time_s);
      rewinder.to(time);
      const auto logged = log.step_before(time);
      ASSERT_TRUE(logged);
      EXPECT_EQ(rewinder.step(), logged->step) << time_s;
      EXPECT_EQ(world.start(), logged->time);
      // Commands that acted since the step change the state: go exactly to the step for hashes.
      rewinder.to(logged->time);
      EXPECT_EQ(step_fingerprint(world.digest().section_hashes), logged->fingerprint)
          << time_s << extra;
    }
  }
}

TEST(Log, HoldsPicturesAndPosesForOtherTools) {
  const RecordedRun run = record(text(0.5), {.pictures = true, .transforms = true, .scene = true});
  const Log log = log_of(run.bytes);
  EXPECT_TRUE(log.has_pictures());
  LogCursor cursor(log, {Topic::frame});
  const auto frame = cursor.next();
  ASSERT_TRUE(frame);
  const auto png = log.picture(std::get<FrameRecord>(*frame));
  ASSERT_TRUE(png);
  EXPECT_TRUE(png->starts_with("\x89PNG"));
  EXPECT_FALSE(verify(log).divergence);
}

// The messages of each chunk, byte by byte.
std::vector<std::vector<std::string>> messages_by_chunk(const Log& log) {
  std::vector<std::vector<std::string>> messages;
  for (const mcap::ChunkPlace& chunk : log.file().contents().chunks) {
    messages.emplace_back();
    log.file().for_each_message(
        chunk, [&](const mcap::Message& m) { messages.back().emplace_back(m.data); });
  }
  return messages;
}

TEST(Log, CutAnywhereItIsRecoveredUpToThere) {
  // One robot and no frames: small chunks, so that every byte of the last two and of the index can
  // be tried.
  const std::string yaml = scenario_text(SEAM_SOURCE_DIR, 1, 1.5, 100);
  const RecordedRun run = record(yaml);
  const Log whole = log_of(run.bytes);
  const auto& chunks = whole.file().contents().chunks;
  ASSERT_GE(chunks.size(), 4u);
  std::vector<uint64_t> cuts;
  for (uint64_t cut = chunks[chunks.size() - 2].offset; cut <= run.bytes.size(); ++cut)
    cuts.push_back(cut);
  for (uint64_t draw = 0; draw < 300; ++draw) {
    cuts.push_back(random_bits({11, 1}, draw)[0] % chunks[chunks.size() - 2].offset);
  }
  const auto messages = messages_by_chunk(whole);
  for (const uint64_t cut : cuts) {
    const std::string damaged = run.bytes.substr(0, cut);
    const auto input = [&] { return std::make_unique<mcap::MemoryInput>(damaged); };
    size_t whole_chunks = 0, whole_messages = 0;
    while (whole_chunks < chunks.size() &&
           chunks[whole_chunks].offset + chunks[whole_chunks].length <= cut) {
      whole_messages += messages[whole_chunks++].size();
    }
    mcap::MemoryOutput output;
    if (whole_chunks == 0) {  // Nothing is left: exit code 1.
      EXPECT_THROW(recover_log(input(), output), InputError) << cut;
      continue;
    }
    const Recovery recovery = recover_log(input(), output);
    EXPECT_EQ(recovery.messages, whole_messages) << cut;
    if (whole_chunks < chunks.size()) {  // Exit code 3.
      EXPECT_FALSE(recovery.whole()) << cut;
      EXPECT_FALSE(recovery.losses.empty()) << cut;
    }
    if (cut == run.bytes.size()) {
      EXPECT_TRUE(recovery.whole());
    }
    if (cut % 64 != 0) continue;
    const Log mended = log_of(output.bytes());
    EXPECT_TRUE(mended.losses().empty()) << cut;
    EXPECT_TRUE(mended.file().contents().complete) << cut;
    EXPECT_EQ(messages_by_chunk(mended),
              std::vector(messages.begin(), messages.begin() + static_cast<long>(whole_chunks)))
        << cut;
  }
}

// Sums of times must not overflow, whatever a hostile log holds.
TEST(Log, TimesBeyondReasonAreRefusedByName) {
  using Limits = std::numeric_limits<int64_t>;
  constexpr int64_t kFar_ns[] = {Limits::max(), Limits::min(), (int64_t{1} << 61) + 1};
  for (const int64_t far_ns : kFar_ns) {
    const SimTime far = SimTime::from_ns(far_ns), near = SimTime::from_ns(1);
    const std::tuple<Topic, LogRecord, const char*> records[] = {
        {Topic::turn, TurnRecord{far, {}}, "turn: time_ns"},
        {Topic::step, StepRecord{far, 1, 0, {}, {}, {}, {}}, "/seam/step: time_ns"},
        {Topic::snapshot, SnapshotRecord{far, 1, ""}, "/seam/snapshot: time_ns"},
        {Topic::frame, FrameRecord{far, 0, 1, near, 0}, "/seam/frame: time_ns"},
        {Topic::frame, FrameRecord{near, 0, 1, far, 0}, "/seam/frame: stamp_ns"},
        {Topic::event, SimulationEvent{far, {}, "", "", ""}, "/seam/event: time_ns"},
        {Topic::end, EndRecord{far, {}, 0, 0, 0}, "/seam/end: time_ns"}};
    for (const auto& [topic, record, field] : records) {
      try {
        decode(topic, encode(record, {"red1"}), {"red1"});
        ADD_FAILURE() << field << " " << far_ns;
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
      }
    }
  }
}

TEST(Log, NamesRobotsAsScenariosDo) {
  const RecordedRun run = record(text(0.1));
  for (const std::string& name :
       {std::string("/tmp/x"), std::string("../x"), std::string("a\0b", 3), std::string(),
        std::string("\x1b[31m"), std::string("r1"), std::string(65, 'a')}) {
    const std::string forged = rewritten(run.bytes, Topic::header, [&](LogRecord& record) {
      std::get<RunHeader>(record).robots[0] = name;
      return true;
    });
    try {
      log_of(forged);
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("/seam/header: robots: found '"));
    }
  }
}

TEST(Log, SaysWhenAFileIsNoLogOfOurs) {
  mcap::MemoryOutput output;
  mcap::Writer writer(output, {});
  writer.write(writer.add_channel(0, "/other", "json"), 1, "{}");
  writer.finish();
  EXPECT_THROW(log_of(output.bytes()), InputError);
}

}  // namespace
}  // namespace seam::scheduler
