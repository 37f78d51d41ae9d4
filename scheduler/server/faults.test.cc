// Many seeded runs with clients that fail in every way we could think of. Each run must go on by
// its policy; the robots with good clients must be told, bit for bit, what they are told in a run
// without gRPC that has the same policy events; and its log must verify, step by step. One run in
// each hundred is a planted fault that must be caught, so that the alarm is known to work: in turn
// a command that changes in the log, and a good client that is told something else.
//
// SEAM_FAULT_RUNS=500 runs more than the 10 of the normal tests; SEAM_FAULT_SEED starts elsewhere.
#include <sys/socket.h>
#include <sys/un.h>

#include <condition_variable>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <set>

#include "scheduler/replay/log_testing.h"
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

// All that a run shows: turns, and a running hash of what each robot was told.
struct Witness final : SimulationObserver {
  std::vector<std::string> robots;
  std::vector<std::string> turns;
  std::vector<uint64_t> told = std::vector<uint64_t>(kRobots, 0);
  uint64_t fingerprint = 0;
  size_t policies = 0, faults = 0;

  void on_start(const RunHeader& header) override { robots = header.robots; }
  void on_observation(const Observation& seen) override {
    v1::Observation wire;
    observation_to_wire(seen, wire);
    Hasher hasher;
    hasher.add(told[static_cast<size_t>(seen.robot)]);
    hasher.add(std::string_view(wire.SerializeAsString()));
    told[static_cast<size_t>(seen.robot)] = hasher.digest();
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

// The recorded turns, but healthy robots decide anew from what they are told (`all_recorded`
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

// The ways to fail. Each is one client's behaviour until the run is over.
enum class Fault {
  killed,
  silent,
  slow,
  reconnecting,
  garbage,
  duplicates,
  stale,
  nan,
  huge,
  half_open,
  shuffled,
  stalled
};
constexpr int kFaults = 12;

// Clients that are stalled one by one, each as its turn comes while the others wait already, and
// then released together, in random order.
class Stall {
 public:
  Stall(int clients, uint64_t seed) : clients_(clients), stream_{seed, 99} {}

  // When the client of this place among the stalled ones is to call `hold`.
  static uint64_t sequence_of(int place) { return 20 + 5 * static_cast<uint64_t>(place); }

  // Returns when all are here (or after 2 s: the run ended for one of them) and it is this one's
  // turn.
  void hold() {
    std::unique_lock lock(mutex_);
    const auto ticket = random_bits(stream_, static_cast<uint64_t>(held_++))[0];
    tickets_.insert(ticket);
    changed_.notify_all();
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    changed_.wait_until(lock, limit,
                        [&] { return held_ >= clients_ && *tickets_.begin() == ticket; });
    std::this_thread::sleep_for(std::chrono::microseconds(ticket % 5000));
    tickets_.erase(ticket);
    ++released_;
    changed_.notify_all();
  }
  int released() const { return released_; }

 private:
  const int clients_;
  const RandomStream stream_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int held_ = 0;
  std::set<uint64_t> tickets_;  // Of those that are held; the lowest goes first.
  std::atomic<int> released_ = 0;
};

class FaultyClient {
 public:
  // `place` is its place among the clients that `stall` holds.
  FaultyClient(const LiveRun& run, int robot, Fault fault, uint64_t seed, Stall& stall,
               int place = 0)
      : address_(run.address),
        id_(run.scenario.robots[static_cast<size_t>(robot)].id),
        robot_(robot),
        fault_(fault),
        stream_{seed, static_cast<uint64_t>(robot)},
        stall_(stall),
        place_(place) {}

  void operator()() {
    const uint64_t strikes_at =
        fault_ == Fault::stalled ? Stall::sequence_of(place_) : 3 + draw() % 200;
    while (!over_) {
      RawClient client(address_);
      if (!client.hello(id_, "token-" + id_)) return;
      v1::ServerMessage message;
      bool again = false;
      while (!again && client.read(message)) {
        if (message.has_goodbye()) over_ = true;
        if (message.has_observation()) again = !answer(client, message.observation(), strikes_at);
      }
      // Only who leaves by itself cancels: the status that the server gave would be lost.
      if (again) client.cancel();
      if (client.finish().error_code() == grpc::StatusCode::FAILED_PRECONDITION) return;  // Over.
      if (fault_ == Fault::killed && struck_) return;
    }
  }

 private:
  uint64_t draw() { return random_bits(stream_, draws_++)[0]; }
  void sleep_ms(uint64_t ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

  // False: leave this connection.
  bool answer(RawClient& client, const v1::Observation& seen, uint64_t strikes_at) {
    v1::Decision decision = busy(robot_, seen);
    const bool once = fault_ == Fault::silent || fault_ == Fault::stalled;
    // A client that was frozen meanwhile may not be told of the very number.
    const bool strike =
        once ? !struck_ && seen.sequence() >= strikes_at
             : seen.sequence() == strikes_at || (seen.sequence() > strikes_at && draw() % 40 == 0);
    if (strike) {
      struck_ = true;
      switch (fault_) {
        case Fault::killed:
          return false;
        case Fault::silent:
          sleep_ms(400);
          break;  // Longer than the limit: frozen, then back.
        case Fault::slow:
          sleep_ms(draw() % 30);
          break;
        case Fault::reconnecting:
          return false;
        case Fault::garbage:
          send_garbage();
          break;
        case Fault::duplicates:
          client.decide(decision);
          break;
        case Fault::stale:
          client.decide(seen.sequence() - draw() % 3);
          break;
        case Fault::nan:
          decision.mutable_walk()->set_vx_m_s(std::numeric_limits<double>::quiet_NaN());
          break;
        case Fault::huge:
          decision.add_messages(std::string(WireLimits::kMaxMessageBytes, 'x'));
          break;
        case Fault::half_open:
          open_and_forget();
          break;
        case Fault::shuffled:
          std::this_thread::sleep_for(std::chrono::microseconds(draw() % 2000));
          break;
        case Fault::stalled:
          stall_.hold();
          break;
      }
    }
    return client.decide(decision);
  }

  int open_socket() const {
    const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{.sun_family = AF_UNIX};
    address_.substr(5).copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    return fd;
  }
  void send_garbage() {
    const int fd = open_socket();
    std::string bytes;
    if (draw() % 2 == 0) bytes = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";  // Good so far.
    for (int i = 0; i < 300; ++i) bytes += static_cast<char>(draw());
    send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    close(fd);
  }
  void open_and_forget() { sockets_.push_back(open_socket()); }

  std::string address_, id_;
  int robot_;
  Fault fault_;
  RandomStream stream_;
  Stall& stall_;
  int place_;
  uint64_t draws_ = 0;
  bool struck_ = false;
  bool over_ = false;
  struct Sockets : std::vector<int> {
    ~Sockets() {
      for (const int fd : *this) close(fd);
    }
  } sockets_;
};

// What was found wrong; empty for a good run.
std::string check(const std::string& scenario_yaml, const Witness& live,
                  const std::vector<bool>& healthy) {
  const Witness replayed = run_again(scenario_yaml, live, std::vector<bool>(kRobots, false));
  if (replayed.fingerprint != live.fingerprint) return "the turns replay to another fingerprint";
  const Witness anew = run_again(scenario_yaml, live, healthy);
  for (size_t robot = 0; robot < kRobots; ++robot)
    if (healthy[robot] && anew.told[robot] != live.told[robot])
      return fmt::format("r{} was told something else than without faults", robot);
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

// A good client is told something that it should not have been.
void plant_in_what_was_told(Witness& live) {
  live.told[0] ^= 1;
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
