// Many seeded runs with clients that fail in every way we could think of. Each run must go on by its
// policy; the robots with good clients must be told, bit for bit, what they are told in a run
// without gRPC that has the same policy events; and the turns must replay to the same fingerprint.
// One run in each hundred is a planted fault that must be caught, so that the alarm is known to
// work.
//
// SEAM_FAULT_RUNS=500 runs more than the 10 of the normal tests; SEAM_FAULT_SEED starts elsewhere.
#include <sys/socket.h>
#include <sys/un.h>

#include <cstdlib>
#include <limits>

#include "scheduler/live_testing.h"
#include "sim_core/hash.h"

namespace seam::scheduler {
namespace {

using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

constexpr int kRobots = 4;
constexpr double kSimulated_s = 10;

int from_environment(const char* name, int fallback) {
  const char* text = std::getenv(name);
  return text == nullptr ? fallback : std::atoi(text);
}

std::string yaml(bool frames) {
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
  void on_turn(SimTime time, const Turn& turn) override { turns.push_back(encode_turn(time, turn, robots)); }
  void on_event(const SimulationEvent& event) override {
    policies += event.kind == EventKind::policy;
    faults += event.kind == EventKind::fault;
  }
  void on_end(SimTime, EndReason, uint64_t run_fingerprint) override { fingerprint = run_fingerprint; }
};

// The recorded turns, but healthy robots decide anew from what they are told (`all_recorded` false).
class Again final : public DecisionSource {
 public:
  Again(const Witness& witness, std::vector<bool> healthy) : witness_(witness), healthy_(std::move(healthy)) {}

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

Witness run_again(const std::string& scenario_yaml, const Witness& witness, std::vector<bool> healthy) {
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
enum class Fault { killed, silent, slow, reconnecting, garbage, duplicates, stale, nan, huge, half_open, shuffled };
constexpr int kFaults = 11;

class FaultyClient {
 public:
  FaultyClient(const LiveRun& run, int robot, Fault fault, uint64_t seed)
      : address_(run.address), id_(run.scenario.robots[static_cast<size_t>(robot)].id), robot_(robot),
        fault_(fault), stream_{seed, static_cast<uint64_t>(robot)} {}

  void operator()() {
    const uint64_t strikes_at = 3 + draw() % 200;
    while (!over_) {
      RawClient client(address_);
      if (!client.hello(id_, "token-" + id_)) return;
      v1::ServerMessage message;
      bool again = false;
      while (!again && client.read(message)) {
        if (message.has_goodbye()) over_ = true;
        if (message.has_observation()) again = !answer(client, message.observation(), strikes_at);
      }
      client.cancel();
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
    const bool strike = seen.sequence() == strikes_at || (seen.sequence() > strikes_at && draw() % 40 == 0);
    if (strike && !(struck_ && fault_ == Fault::silent)) {
      struck_ = true;
      switch (fault_) {
        case Fault::killed: return false;
        case Fault::silent: sleep_ms(400); break;  // Longer than the limit: frozen, then back.
        case Fault::slow: sleep_ms(draw() % 30); break;
        case Fault::reconnecting: return false;
        case Fault::garbage: send_garbage(); break;
        case Fault::duplicates: client.decide(decision); break;
        case Fault::stale: client.decide(seen.sequence() - draw() % 3); break;
        case Fault::nan:
          decision.mutable_walk()->set_vx_m_s(std::numeric_limits<double>::quiet_NaN());
          break;
        case Fault::huge: decision.add_messages(std::string(WireLimits::kMaxMessageBytes, 'x')); break;
        case Fault::half_open: open_and_forget(); break;
        case Fault::shuffled: std::this_thread::sleep_for(std::chrono::microseconds(draw() % 2000)); break;
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
std::string check(const std::string& scenario_yaml, const Witness& live, const std::vector<bool>& healthy) {
  const Witness replayed = run_again(scenario_yaml, live, std::vector<bool>(kRobots, false));
  if (replayed.fingerprint != live.fingerprint) return "the turns replay to another fingerprint";
  const Witness anew = run_again(scenario_yaml, live, healthy);
  for (size_t robot = 0; robot < kRobots; ++robot)
    if (healthy[robot] && anew.told[robot] != live.told[robot])
      return fmt::format("r{} was told something else than without faults", robot);
  return "";
}

// One byte of one number of one recorded command changes: the kind of error that the checks are for.
void plant(Witness& live, uint64_t seed) {
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

TEST(Faults, TheMatchGoesOnAndWhatHappenedReplays) {
  const int runs = from_environment("SEAM_FAULT_RUNS", 10);
  const int first = from_environment("SEAM_FAULT_SEED", 0);
  int planted = 0, caught = 0;
  for (int i = first; i < first + runs; ++i) {
    const auto seed = static_cast<uint64_t>(i);
    const RandomStream stream{seed, 77};
    const std::string scenario_yaml = yaml(i % 10 == 3);
    Witness live;
    std::vector<bool> healthy(kRobots, true);
    {
      LiveRun run(scenario_yaml, {&live});
      std::vector<std::thread> clients;
      std::vector<std::unique_ptr<FaultyClient>> faulty;
      for (int robot = 0; robot < kRobots; ++robot) {
        const auto fault = static_cast<Fault>((i + 3 * robot + random_bits(stream, 1)[0]) % kFaults);
        healthy[static_cast<size_t>(robot)] = robot == 0 || random_bits(stream, 10 + robot)[0] % 3 == 0;
        if (healthy[static_cast<size_t>(robot)]) {
          clients.push_back(good_client(run, robot, busy));
          continue;
        }
        faulty.push_back(std::make_unique<FaultyClient>(run, robot, fault, seed));
        clients.emplace_back(std::ref(*faulty.back()));
      }
      run.start();
      run.wait();
      for (std::thread& client : clients) client.join();
      ASSERT_EQ(run.end, EndReason::finished) << "run " << i;
    }
    // A loaded machine may freeze a good client too: that is a policy event like any other.
    const bool plant_here = i % 100 == 7;
    if (plant_here) plant(live, seed);
    const std::string wrong = check(scenario_yaml, live, healthy);
    if (plant_here) {
      ++planted;
      caught += !wrong.empty();
    } else {
      ASSERT_EQ(wrong, "") << "run " << i << " (SEAM_FAULT_SEED=" << i << " SEAM_FAULT_RUNS=1)";
    }
  }
  EXPECT_EQ(caught, planted);
  RecordProperty("planted", planted);
}

}  // namespace
}  // namespace seam::scheduler
