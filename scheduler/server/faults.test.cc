// Many seeded runs with clients that fail in every way we could think of. Each run must go on by
// its policy; the robots with good clients must get, bit for bit, what they get in a run
// without gRPC that has the same policy events; and its log must verify, step by step. One run in
// each hundred is a planted fault that must be caught, so that the alarm is known to work: in turn
// a command that changes in the log, and a good client that gets something else.
//
// SEAM_FAULT_RUNS=500 runs more than the 10 of the normal tests; SEAM_FAULT_SEED starts elsewhere.
#include <cstdlib>
#include <set>

#include "scheduler/replay/log_testing.h"
#include "scheduler/server/faulty_client_testing.h"
#include "scheduler/server/live_testing.h"
#include "sim_core/base/hash.h"

namespace seam::scheduler {
namespace {

using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

constexpr int kRobots = 4;
constexpr double kSimulated_s = 10;

int from_environment(const char* name, int fallback) {
  const char* text = std::getenv(name);
  return text == nullptr ? fallback : std::atoi(text);
}

std::string faulty_scenario(bool frames) {
  return scenario_text(SEAM_SOURCE_DIR, kRobots, frames ? 1.0 : kSimulated_s, 32,
                       ", silence: freeze, wall_limit_s: 0.15");
}

// All that a run shows: turns, and a running hash of what each robot got.
struct Witness final : SimulationObserver {
  std::vector<std::string> robots;
  std::vector<std::string> turns;
  std::vector<uint64_t> heard = std::vector<uint64_t>(kRobots, 0);
  uint64_t fingerprint = 0;
  size_t policies = 0, faults = 0;

  void on_start(const RunHeader& header) override { robots = header.robots; }
  void on_observation(const Observation& seen) override {
    v1::Observation wire;
    observation_to_wire(seen, wire);
    Hasher hasher;
    hasher.add(heard[static_cast<size_t>(seen.robot)]);
    hasher.add(std::string_view(wire.SerializeAsString()));
    heard[static_cast<size_t>(seen.robot)] = hasher.digest();
  }
  void on_turn(SimTime time, const Turn& turn) override {
    turns.push_back(encode_turn(time, turn, robots));
  }
  void on_event(const SimulationEvent& event) override {
    policies += event.kind == EventKind::policy;
    faults += event.kind == EventKind::fault;
  }
  void on_end(SimTime, EndReason, uint64_t run_fingerprint) override {
    fingerprint = run_fingerprint;
  }
};

// The recorded turns, but healthy robots decide anew from what they get (`all_recorded`
// false).
class Again final : public DecisionSource {
 public:
  Again(const Witness& witness, std::vector<bool> healthy)
      : witness_(witness), healthy_(std::move(healthy)) {}

  std::optional<Turn> decide(SimTime now,
                             std::span<const std::shared_ptr<const Observation>> seen) override {
    if (next_ >= witness_.turns.size()) return std::nullopt;
    auto [time, turn] = decode_turn(witness_.turns[next_++], witness_.robots);
    if (time != now) return std::nullopt;
    for (size_t i = 0; i < turn.answers.size(); ++i) {
      Answer& answer = turn.answers[i];
      if (!healthy_[static_cast<size_t>(answer.robot)]) continue;
      v1::Observation wire;
      observation_to_wire(*seen[i], wire);
      answer.decision = std::get<Decision>(decision_from_wire(busy(answer.robot, wire), 1024));
    }
    return turn;
  }

 private:
  const Witness& witness_;
  std::vector<bool> healthy_;
  size_t next_ = 0;
};

Witness run_again(const std::string& scenario_yaml, const Witness& witness,
                  std::vector<bool> healthy) {
  const Scenario scenario = Scenario::from_text(scenario_yaml, "test.yaml");
  World world(scenario);
  RunControl control;
  HashRenderer renderer(scenario, 1);
  Again source(witness, std::move(healthy));
  Witness again;
  RunHeader header;
  for (const RobotSpec& robot : scenario.robots) header.robots.push_back(robot.id);
  Simulation simulation({scenario, world, source, control, &renderer, {&again}, header});
  simulation.run();
  return again;
}

// What was found wrong; empty for a good run.
std::string check(const std::string& scenario_yaml, const Witness& live,
                  const std::vector<bool>& healthy) {
  const Witness replayed = run_again(scenario_yaml, live, std::vector<bool>(kRobots, false));
  if (replayed.fingerprint != live.fingerprint) return "the turns replay to another fingerprint";
  const Witness anew = run_again(scenario_yaml, live, healthy);
  for (size_t robot = 0; robot < kRobots; ++robot)
    if (healthy[robot] && anew.heard[robot] != live.heard[robot])
      return fmt::format("r{} got something else than without faults", robot);
  return "";
}

// The log as it was written while the clients failed.
std::string check_log(const std::string& bytes, const Witness& live) {
  const Log log = log_of(bytes);
  const Verification verified = verify(log);
  if (verified.divergence)
    return fmt::format("the log diverges at {} ns in {}", verified.divergence->time.ns(),
                       verified.divergence->section);
  if (!log.end() || log.end()->fingerprint != live.fingerprint)
    return "the log ends with another fingerprint";
  return "";
}

// A good client gets something that it should not have got.
void plant_in_what_was_told(Witness& live) {
  live.heard[0] ^= 1;
}

// One number of one recorded command changes by 1e-9: the kind of error that the checks are for.
void plant_in_a_command(Witness& live, uint64_t seed) {
  for (size_t i = live.turns.size() / 2 + seed % 20; i < live.turns.size(); ++i) {
    auto [time, turn] = decode_turn(live.turns[i], live.robots);
    for (Answer& answer : turn.answers)
      for (JointFrame& frame : answer.decision.command.joints)
        for (JointTarget& target : frame.targets)
          if (target.joint == kPan) {
            target.angle_rad += 1e-9;
            live.turns[i] = encode_turn(time, turn, live.robots);
            return;
          }
  }
}

// Who fails in this run, and how: robot 0 never does, the others mostly, each kind in its turn. In
// one run of six a random subset of two or more is stalled together.
std::vector<std::optional<Fault>> faults_of_run(int number) {
  const RandomStream stream{static_cast<uint64_t>(number), 77};
  std::vector<std::optional<Fault>> faults(kRobots);
  const int spared = 1 + static_cast<int>(random_bits(stream, 0)[0] % kRobots);  // kRobots: nobody.
  for (int robot = 1; robot < kRobots; ++robot) {
    if (robot == spared) continue;
    const int turn = (kRobots - 1) * number + robot - 1;
    faults[static_cast<size_t>(robot)] =
        number % 6 == 5 ? Fault::stalled : static_cast<Fault>(turn % (kFaults - 1));
  }
  return faults;
}

TEST(Faults, EachKindIsAmongTheRunsOfTheShortTest) {
  std::set<int> kinds;
  size_t most_stalled = 0;
  for (int number = 0; number < 10; ++number) {
    size_t stalled = 0;
    for (const auto& fault : faults_of_run(number)) {
      if (fault) kinds.insert(static_cast<int>(*fault));
      stalled += fault == Fault::stalled;
    }
    most_stalled = std::max(most_stalled, stalled);
  }
  EXPECT_EQ(kinds.size(), static_cast<size_t>(kFaults));
  EXPECT_GE(most_stalled, 2u);
}

TEST(Faults, TheMatchGoesOnAndWhatHappenedReplays) {
  const int runs = from_environment("SEAM_FAULT_RUNS", 10);
  const int first = from_environment("SEAM_FAULT_SEED", 0);
  int planted = 0, caught = 0;
  size_t policies = 0, refused = 0;
  int stalled = 0;
  for (int i = first; i < first + runs; ++i) {
    const auto seed = static_cast<uint64_t>(i);
    const std::string scenario_yaml = faulty_scenario(i % 10 == 3);
    const std::vector<std::optional<Fault>> faults = faults_of_run(i);
    Witness live;
    mcap::MemoryOutput log;
    std::vector<bool> healthy;
    for (const auto& fault : faults) healthy.push_back(!fault);
    {
      LiveRun run(scenario_yaml, {&live});
      Recorder recorder(log, run.world);
      run.observe(recorder);
      const auto stalls = std::count(faults.begin(), faults.end(), Fault::stalled);
      Stall stall(static_cast<int>(stalls), seed);
      std::vector<std::thread> clients;
      std::vector<std::unique_ptr<FaultyClient>> faulty;
      int place = 0;
      for (int robot = 0; robot < kRobots; ++robot) {
        const auto& fault = faults[static_cast<size_t>(robot)];
        if (!fault) {
          clients.push_back(good_client(run, robot, busy));
          continue;
        }
        faulty.push_back(std::make_unique<FaultyClient>(run, robot, *fault, seed, stall, place));
        place += *fault == Fault::stalled;
        clients.emplace_back(std::ref(*faulty.back()));
      }
      run.start(header_of(run.scenario, scenario_yaml));
      run.wait();
      for (std::thread& client : clients) client.join();
      ASSERT_EQ(run.end, EndReason::finished) << "run " << i;
      // On a loaded machine a client may stay frozen to the end and never come to its stall.
      ASSERT_LE(stall.released(), stalls) << "run " << i;
      stalled += stall.released();
    }
    policies += live.policies;
    refused += live.faults;
    const std::string again = fmt::format("run {} (SEAM_FAULT_SEED={} SEAM_FAULT_RUNS=1)", i, i);
    ASSERT_EQ(check_log(log.bytes(), live), "") << again;
    // A loaded machine may freeze a good client too: that is a policy event like any other.
    const bool plant_here = i % 100 == 7;
    if (plant_here && i / 100 % 2 == 0) plant_in_a_command(live, seed);
    if (plant_here && i / 100 % 2 == 1) plant_in_what_was_told(live);
    const std::string wrong = check(scenario_yaml, live, healthy);
    if (plant_here) {
      ++planted;
      caught += !wrong.empty();
    } else {
      ASSERT_EQ(wrong, "") << again;
    }
  }
  EXPECT_EQ(caught, planted);
  if (runs >= 10) {
    EXPECT_GT(stalled, 0);
  }
  std::printf(
      "%d runs: %zu policy events, %zu refused or lost messages, %d clients stalled; %d of %d "
      "planted faults caught\n",
      runs, policies, refused, stalled, caught, planted);
}

}  // namespace
}  // namespace seam::scheduler
