// The server over real gRPC: determinism with live clients, and everything that a client may do
// wrong.
#include "scheduler/server/server.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <limits>
#include <random>

#include "scheduler/server/live_testing.h"
#include "sim_core/base/error.h"

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

std::string yaml(int robots = 3, const std::string& behaviour_extra = "", double duration_s = 0.3) {
  return scenario_text(SEAM_SOURCE_DIR, robots, duration_s, 32, behaviour_extra);
}

struct Events final : SimulationObserver {
  std::vector<SimulationEvent> all;
  void on_event(const SimulationEvent& event) override { all.push_back(event); }
  std::vector<std::string> of(EventKind kind) const {
    std::vector<std::string> lines;
    for (const SimulationEvent& event : all)
      if (event.kind == kind) lines.push_back(event.robot + " " + event.name + " " + event.detail);
    return lines;
  }
};

TEST(Server, ShuffledAndDelayedAnswersGiveTheSameBits) {
  const uint64_t reference = reference_fingerprint(yaml(), busy);
  for (int seed = 0; seed < 3; ++seed) {
    LiveRun run(yaml());
    std::vector<std::thread> clients;
    for (int robot = 0; robot < 3; ++robot)
      clients.push_back(good_client(run, robot, [seed](int r, const v1::Observation& seen) {
        const auto delay =
            random_bits({static_cast<uint64_t>(seed * 10 + r), 5}, seen.sequence())[0];
        std::this_thread::sleep_for(std::chrono::microseconds(delay % 3000));
        return busy(r, seen);
      }));
    run.start();
    EXPECT_EQ(run.fingerprint(), reference) << seed;
    for (std::thread& client : clients) client.join();
  }
}

TEST(Server, RefusesWhoMustNotBeThere) {
  LiveRun run(yaml(1));
  v1::ServerMessage message;
  const auto status_of = [&](auto&& talk) {
    RawClient client(run.address);
    talk(client);
    while (client.read(message)) {
    }
    return client.finish();
  };
  const auto wrong = status_of([](RawClient& c) { c.hello("r0", "guess"); });
  EXPECT_EQ(wrong.error_code(), grpc::StatusCode::UNAUTHENTICATED);
  EXPECT_THAT(wrong.error_message(), HasSubstr("token: not the token of robot 'r0'"));
  // A token in part, another's token, the supervisor's token.
  for (const char* token : {"", "token-r", "token-r1", "boss"})
    EXPECT_EQ(status_of([&](RawClient& c) { c.hello("r0", token); }).error_code(),
              grpc::StatusCode::UNAUTHENTICATED)
        << token;
  const auto unknown = status_of([](RawClient& c) { c.hello("nobody", "token-r0"); });
  EXPECT_EQ(unknown.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(unknown.error_message(), HasSubstr("robot: no robot 'nobody'"));
  const auto early = status_of([](RawClient& c) { c.decide(1); });
  EXPECT_EQ(early.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(early.error_message(), HasSubstr("Hello"));
}

TEST(Server, BadNumbersAreRefusedWithTheFieldNamedAndCountAsAnEmptyDecision) {
  // Reference: robot 1's third decision is empty.
  const auto sparse = [](int robot, const v1::Observation& seen) {
    v1::Decision decision = busy(robot, seen);
    if (robot == 1 && seen.sequence() == 3) decision.Clear();
    decision.set_sequence(seen.sequence());
    return decision;
  };
  const uint64_t reference = reference_fingerprint(yaml(2), sparse);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(v1::Decision&)>>> bad = {
      {"walk.vx_m_s", [&](v1::Decision& d) { d.mutable_walk()->set_vx_m_s(nan); }},
      {"head.pan_rad", [&](v1::Decision& d) { d.mutable_head()->set_pan_rad(1e300); }},
      {"head.max_speed_rad_s", [&](v1::Decision& d) { d.mutable_head()->set_max_speed_rad_s(-1); }},
      {"joints[0].targets[0].joint",
       [](v1::Decision& d) { d.add_joints()->add_targets()->set_joint(99); }},
      {"joints[0].offset",
       [](v1::Decision& d) {
         d.clear_head();
         d.add_joints()->set_offset_ns(-5);
       }},
      {"kick", [](v1::Decision& d) { d.set_kick(static_cast<v1::Kick>(77)); }},
      {"messages[0]", [](v1::Decision& d) { d.add_messages(std::string(5000, 'x')); }},
      {"frame_requests[0].count",
       [](v1::Decision& d) { d.add_frame_requests()->set_count(1 << 30); }},
      {"debug[0].name", [](v1::Decision& d) { d.add_debug()->set_text("unnamed"); }},
      {"decision",
       [](v1::Decision& d) {
         d.add_debug()->set_text(std::string(WireLimits::kMaxMessageBytes, 'x'));
       }},
  };
  for (const auto& [field, spoil] : bad) {
    Events events;
    LiveRun run(yaml(2), {&events});
    std::thread other = good_client(run, 0, busy);
    std::string refused;
    std::thread spoiler([&, spoil = spoil] {
      RawClient client(run.address);
      client.hello("r1", "token-r1");
      v1::ServerMessage message;
      while (client.read(message) && !message.has_goodbye()) {
        if (message.has_refusal()) {
          refused = message.refusal().field();
          EXPECT_FALSE(message.refusal().decision_owed());
        }
        if (!message.has_observation()) continue;
        v1::Decision decision = busy(1, message.observation());
        if (decision.sequence() == 3) spoil(decision);
        client.decide(decision);
      }
    });
    run.start();
    EXPECT_EQ(run.fingerprint(), reference) << field;
    other.join();
    spoiler.join();
    EXPECT_EQ(refused, field);
    ASSERT_EQ(events.of(EventKind::fault).size(), 1u) << field;
    EXPECT_THAT(events.of(EventKind::fault)[0], HasSubstr("r1 refused " + field));
  }
}

TEST(Server, StaleDuplicateAndFutureSequencesChangeNothing) {
  const uint64_t reference = reference_fingerprint(yaml(2), busy);
  LiveRun run(yaml(2));
  std::thread other = good_client(run, 0, busy);
  std::vector<std::string> refusals;
  std::thread odd([&] {
    RawClient client(run.address);
    client.hello("r1", "token-r1");
    v1::ServerMessage message;
    while (client.read(message) && !message.has_goodbye()) {
      if (message.has_refusal()) refusals.push_back(message.refusal().message());
      if (!message.has_observation()) continue;
      const uint64_t sequence = message.observation().sequence();
      if (sequence == 3) client.decide(1);          // Stale.
      if (sequence == 4) client.decide(4'000'000);  // Future.
      client.decide(busy(1, message.observation()));
      if (sequence == 5) {  // Duplicate, unless time has gone on: stale.
        v1::Decision twice = busy(0, message.observation());
        client.decide(twice);
      }
      if (sequence == 6) {  // A second hello.
        v1::ClientMessage hello;
        hello.mutable_hello()->set_robot("r0");
        client.write(hello);
      }
    }
  });
  run.start();
  EXPECT_EQ(run.fingerprint(), reference);
  other.join();
  odd.join();
  EXPECT_EQ(refusals.size(), 4u);
}

TEST(Server, OversizedMessageEndsItsStreamOnlyAndTheClientMayComeBack) {
  const uint64_t reference = reference_fingerprint(yaml(2), busy);
  LiveRun run(yaml(2));
  std::thread other = good_client(run, 0, busy);
  grpc::Status status;
  std::thread big([&] {
    v1::ServerMessage message;
    {
      RawClient client(run.address);
      client.hello("r1", "token-r1");
      while (client.read(message)) {
        if (!message.has_observation()) continue;
        v1::Decision decision = busy(1, message.observation());
        if (decision.sequence() == 4)
          decision.add_messages(std::string(WireLimits::kMaxReceivedBytes, 'x'));
        client.decide(decision);
      }
      status = client.finish();
    }
    good_client(run, 1, busy).join();
  });
  run.start();
  EXPECT_EQ(run.fingerprint(), reference);
  other.join();
  big.join();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST(Server, ReconnectedClientResumesAtThePendingObservation) {
  const uint64_t reference = reference_fingerprint(yaml(2), busy);
  LiveRun run(yaml(2));
  std::thread other = good_client(run, 0, busy);
  std::thread restless([&] {
    uint64_t last = 0;
    while (true) {
      RawClient client(run.address);
      if (!client.hello("r1", "token-r1")) return;
      v1::ServerMessage message;
      while (client.read(message)) {
        if (message.has_goodbye()) return;
        if (!message.has_observation()) continue;
        const uint64_t sequence = message.observation().sequence();
        const bool again = std::exchange(last, sequence) == sequence;
        if (sequence % 3 == 2 && !again) break;  // Breaks off without an answer.
        client.decide(busy(1, message.observation()));
      }
      client.cancel();
    }
  });
  run.start();
  EXPECT_EQ(run.fingerprint(), reference);
  other.join();
  restless.join();
}

TEST(Server, AnotherConnectionWithTheTokenTakesOver) {
  LiveRun run(yaml(1));
  RawClient first(run.address);
  first.hello("r0", "token-r0");
  v1::ServerMessage message;
  ASSERT_TRUE(first.read_until(v1::ServerMessage::kWelcome, message));
  std::thread second = good_client(run, 0, busy);
  while (first.read(message)) {
  }
  EXPECT_EQ(first.finish().error_code(), grpc::StatusCode::ABORTED);
  run.start();
  run.wait();
  second.join();
  EXPECT_EQ(run.end, EndReason::finished);
}

TEST(Server, FreezePolicyLetsTheOthersGoOnAndTheRobotComeBack) {
  Events events;
  LiveRun run(yaml(2, ", silence: freeze, wall_limit_s: 0.4"), {&events});
  std::thread other = good_client(run, 0, busy);
  std::thread silent([&] {
    RawClient client(run.address);
    client.hello("r1", "token-r1");
    v1::ServerMessage message;
    while (client.read(message) && !message.has_goodbye()) {
      if (!message.has_observation()) continue;
      if (message.observation().sequence() == 3)
        std::this_thread::sleep_for(std::chrono::milliseconds(1000));
      client.decide(busy(1, message.observation()));
    }
  });
  run.start();
  run.wait();
  other.join();
  silent.join();
  EXPECT_EQ(run.end, EndReason::finished);
  const auto policies = events.of(EventKind::policy);
  ASSERT_GE(policies.size(), 1u);
  EXPECT_EQ(policies[0], "r1 freeze no answer within 0.4 s of wall time");
}

TEST(Server, AbortPolicyEndsTheRun) {
  Events events;
  LiveRun run(yaml(2, ", silence: abort, wall_limit_s: 0.05"), {&events});
  std::thread other = good_client(run, 0, busy);
  RawClient silent(run.address);
  silent.hello("r1", "token-r1");
  v1::ServerMessage message;
  ASSERT_TRUE(silent.read_until(v1::ServerMessage::kWelcome, message));
  run.start();
  run.wait();
  other.join();
  EXPECT_EQ(run.end, EndReason::aborted);
  EXPECT_THAT(events.of(EventKind::policy)[0], HasSubstr("r1 abort"));
}

TEST(Server, WaitPolicyAbortsWhenNobodyCanAnswerAnyMore) {
  LiveRun run(yaml(1));
  run.start();
  run.hub.give_up("r0", "its behaviour ended with exit code 3");
  run.wait();
  EXPECT_EQ(run.end, EndReason::aborted);
}

TEST(Server, GarbageBytesAndHalfOpenConnectionsHarmNobody) {
  const uint64_t reference = reference_fingerprint(yaml(2), busy);
  LiveRun run(yaml(2));
  std::vector<int> sockets;
  for (int i = 0; i < 8; ++i) {
    const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{.sun_family = AF_UNIX};
    run.address.substr(5).copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    std::string garbage;
    for (uint64_t k = 0; k < 500; ++k)
      garbage += static_cast<char>(random_bits({7, static_cast<uint64_t>(i)}, k)[0]);
    if (i % 2 == 0) {
      ASSERT_GT(send(fd, garbage.data(), garbage.size(), MSG_NOSIGNAL), 0);
    }
    sockets.push_back(fd);  // Left open: half of them never said a word.
  }
  std::thread a = good_client(run, 0, busy), b = good_client(run, 1, busy);
  run.start();
  EXPECT_EQ(run.fingerprint(), reference);
  a.join();
  b.join();
  for (const int fd : sockets) close(fd);
}

TEST(Server, PlainConnectionsStayLocal) {
  const Scenario scenario = Scenario::from_text(yaml(1), "test.yaml");
  World world(scenario);
  RunControl control;
  ClientHub hub(LiveRun::hub_robots(scenario), control);
  EXPECT_THROW(Server({{"0.0.0.0:0"}, {}, "boss"}, scenario, world, hub, control), UsageError);
  const Server local({{"127.0.0.1:0"}, {}, "boss"}, scenario, world, hub, control);
  EXPECT_NE(local.addresses()[0], "127.0.0.1:0");
  EXPECT_THROW(Server({{local.addresses()[0]}, {}, "boss"}, scenario, world, hub, control),
               InputError);
}

// ---- Services that tools expect ----

TEST(Server, HealthAndReflectionAnswer) {
  LiveRun run(yaml(1));
  // HealthCheckResponse{status: SERVING}.
  EXPECT_EQ(call_by_name(run.address, "/grpc.health.v1.Health/Check", "").messages.at(0),
            std::string("\x08\x01", 2));
  // ServerReflectionRequest{list_services: ""}.
  const std::string services =
      call_by_name(run.address, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                   std::string("\x3a\x00", 2))
          .messages.at(0);
  EXPECT_THAT(services, HasSubstr("seam.v1.Simulation"));
  EXPECT_THAT(services, HasSubstr("seam.v1.Supervisor"));
}

}  // namespace
}  // namespace seam::scheduler
