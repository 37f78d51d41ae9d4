#include "scheduler/loop/simulation.h"

#include <gtest/gtest.h>

#include "scheduler/loop/testing.h"
#include "scheduler/wire/wire.h"

namespace seam::scheduler {
namespace {

using testing::HashRenderer;
using testing::scenario_text;

// Swings the head, walks, asks for frames; depends on all that it gets.
Decision busy(const Observation& seen) {
  Decision decision;
  const double pan = 0.4 * ((seen.sequence + seen.robot) % 3) - 0.4;
  decision.command.joints = {{SimDuration::from_ns(1'000'000 * seen.robot), {{kPan, pan, 3.0}}}};
  if (seen.sequence % 4 == 1)
    decision.command.walk = BodyVelocity{0.1, 0, 0.2 * seen.sensors.joints.rad[kPan]};
  if (seen.sequence == 1) decision.frame_requests = {{.which = FrameRequest::Which::all}};
  return decision;
}

struct Recorded final : SimulationObserver {
  std::vector<std::pair<int64_t, std::vector<uint64_t>>> steps;
  std::vector<std::tuple<int64_t, std::string, uint64_t, uint64_t>> frames;
  std::vector<std::string> turns;
  std::vector<SimulationEvent> events;
  std::vector<std::string> robots;
  std::optional<EndReason> end;

  void on_step(SimTime time, uint64_t, const StateDigest& state) override {
    steps.emplace_back(time.ns(), state.section_hashes);
  }
  void on_frame(SimTime time, const FrameJob& job, const Frame& frame) override {
    EXPECT_EQ(job.instants.size(), job.schedule.instants.size());
    frames.emplace_back(time.ns(), frame.robot, frame.frame_index, frame.fingerprint);
  }
  void on_turn(SimTime time, const Turn& turn) override {
    turns.push_back(encode_turn(time, turn, robots));
  }
  void on_event(const SimulationEvent& event) override { events.push_back(event); }
  void on_end(SimTime, EndReason reason, uint64_t) override { end = reason; }
};

struct RunSettings {
  std::optional<uint64_t> permutation;
  int workers = 1;
  bool dawdle = false;
};

uint64_t run(const std::string& yaml, DecisionSource& decisions, Recorded* recorded,
             const RunSettings& settings = {}) {
  const Scenario scenario = Scenario::from_text(yaml, "test.yaml");
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario, settings.workers, settings.dawdle);
  std::vector<SimulationObserver*> observers;
  if (recorded != nullptr) observers.push_back(recorded);
  Simulation simulation({scenario, world, decisions, control, &renderer, observers, {}},
                        {.permutation_seed = settings.permutation});
  simulation.run();
  return simulation.fingerprint();
}

std::string text(int robots = 3, double duration_s = 0.6) {
  return scenario_text(SEAM_SOURCE_DIR, robots, duration_s);
}

TEST(Simulation, RepeatsToTheBit) {
  FunctionSource a(busy), b(busy);
  Recorded first, second;
  EXPECT_EQ(run(text(), a, &first), run(text(), b, &second));
  EXPECT_EQ(first.steps, second.steps);
  EXPECT_EQ(first.frames, second.frames);
  EXPECT_GT(first.frames.size(), 30u);
  EXPECT_EQ(first.end, EndReason::finished);
}

TEST(Simulation, SeedAndDecisionsChangeTheFingerprint) {
  FunctionSource still([](const Observation&) { return Decision{}; }), moving(busy), again(busy);
  const uint64_t reference = run(text(), moving, nullptr);
  EXPECT_NE(reference, run(text(), still, nullptr));
  std::string other = text();
  other.replace(other.find("vx_mps: 0.5"), 11, "vx_mps: 0.6");
  EXPECT_NE(reference, run(other, again, nullptr));
}

TEST(Simulation, PermutedInsertionOfEventsChangesNothing) {
  FunctionSource source(busy);
  Recorded reference;
  const uint64_t fingerprint = run(text(), source, &reference);
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Recorded permuted;
    FunctionSource again(busy);
    ASSERT_EQ(run(text(), again, &permuted, {.permutation = seed}), fingerprint) << seed;
    ASSERT_EQ(permuted.turns, reference.turns);
    ASSERT_EQ(permuted.frames, reference.frames);
  }
}

TEST(Simulation, RenderThreadsAndTheirPaceChangeNothing) {
  FunctionSource source(busy);
  Recorded reference;
  const uint64_t fingerprint = run(text(), source, &reference);
  for (int workers : {1, 2, 4}) {
    Recorded other;
    FunctionSource again(busy);
    EXPECT_EQ(run(text(), again, &other, {.workers = workers, .dawdle = true}), fingerprint);
    EXPECT_EQ(other.frames, reference.frames);
  }
}

// Answers from the recorded turns.
class Replayed final : public DecisionSource {
 public:
  Replayed(std::vector<std::string> turns, std::vector<std::string> robots)
      : turns_(std::move(turns)), robots_(std::move(robots)) {}
  std::optional<Turn> decide(SimTime now,
                             std::span<const std::shared_ptr<const Observation>>) override {
    auto [time, turn] = decode_turn(turns_.at(next_++), robots_);
    EXPECT_EQ(time, now);
    return turn;
  }

 private:
  std::vector<std::string> turns_, robots_;
  size_t next_ = 0;
};

TEST(Simulation, EncodedTurnsReplayToTheSameBits) {
  FunctionSource source(busy);
  Recorded live;
  live.robots = {"r0", "r1", "r2"};
  const uint64_t fingerprint = run(text(), source, &live);
  Replayed replayed(live.turns, live.robots);
  Recorded again;
  EXPECT_EQ(run(text(), replayed, &again), fingerprint);
  EXPECT_EQ(again.steps, live.steps);
}

// A source that freezes r1 at its third turn and lets it come back at its sixth.
class Freezing final : public DecisionSource {
 public:
  std::optional<Turn> decide(
      SimTime, std::span<const std::shared_ptr<const Observation>> observations) override {
    Turn turn;
    for (const auto& seen : observations) {
      Answer answer{seen->robot, seen->sequence, Outcome::decided, busy(*seen), {}};
      if (seen->robot == 1 && seen->sequence == 3) answer = {1, 3, Outcome::frozen, {}, "test"};
      if (seen->robot == 1 && seen->sequence > 3 && seen->sequence < 6)
        answer = {1, seen->sequence, Outcome::absent, {}, {}};
      if (seen->robot == 1 && seen->sequence == 6) answer.outcome = Outcome::resumed;
      turn.answers.push_back(std::move(answer));
    }
    return turn;
  }
};

TEST(Simulation, PoliciesAreEventsAndReplayToo) {
  Freezing source;
  Recorded live;
  live.robots = {"r0", "r1", "r2"};
  const uint64_t fingerprint = run(text(), source, &live);
  std::vector<std::string> policies;
  for (const SimulationEvent& event : live.events)
    if (event.kind == EventKind::policy) policies.push_back(event.robot + " " + event.name);
  EXPECT_EQ(policies, (std::vector<std::string>{"r1 freeze", "r1 resume"}));
  Replayed replayed(live.turns, live.robots);
  EXPECT_EQ(run(text(), replayed, nullptr), fingerprint);
  FunctionSource unfrozen(busy);
  EXPECT_NE(run(text(), unfrozen, nullptr), fingerprint);
}

TEST(Simulation, NextFramesComeAfterTheTimeAskedForAndNotMore) {
  FunctionSource source([](const Observation& seen) {
    Decision decision;
    if (seen.robot == 0 && seen.sequence == 1)
      decision.frame_requests = {{.count = 3, .after = SimTime::from_s(0.2)}};
    return decision;
  });
  Recorded recorded;
  run(text(), source, &recorded);
  ASSERT_EQ(recorded.frames.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(std::get<1>(recorded.frames[i]), "r0");
    EXPECT_EQ(std::get<2>(recorded.frames[i]), 5 + i);  // Stamps 0.20, 0.24, 0.28 s.
  }
}

TEST(Simulation, RunToStopsBetweenEventsAndGoesOn) {
  const Scenario scenario = Scenario::from_text(text(), "test.yaml");
  FunctionSource whole_source(busy), parts_source(busy);
  const uint64_t fingerprint = run(text(), whole_source, nullptr);
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario);
  Simulation simulation({scenario, world, parts_source, control, &renderer, {}, {}});
  for (int i = 1; i < 60; ++i) EXPECT_TRUE(simulation.run_to(SimTime::from_ns(i * 10'000'001)));
  EXPECT_EQ(simulation.run(), EndReason::finished);
  EXPECT_EQ(simulation.fingerprint(), fingerprint);
}

TEST(Simulation, StopsCleanlyWhenAsked) {
  const Scenario scenario = Scenario::from_text(text(), "test.yaml");
  World world(scenario);
  RunControl control;
  FunctionSource source([&](const Observation& seen) {
    if (seen.sequence == 5) control.stop();
    return Decision{};
  });
  Recorded recorded;
  Simulation simulation({scenario, world, source, control, nullptr, {&recorded}, {}});
  EXPECT_EQ(simulation.run(), EndReason::stopped);
  EXPECT_EQ(recorded.end, EndReason::stopped);
  EXPECT_LT(simulation.now(), SimTime::from_s(0.6));
}

}  // namespace
}  // namespace seam::scheduler
