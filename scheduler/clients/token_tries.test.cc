#include "scheduler/clients/token_tries.h"

#include <gmock/gmock.h>

#include "scheduler/server/live_testing.h"

namespace seam::scheduler {
namespace {

using ::testing::HasSubstr;
using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

struct Wall {
  TokenTries::Clock::time_point now;
  void pass(double s) { now += std::chrono::microseconds(static_cast<int64_t>(1e6 * s)); }
};

TEST(TokenTries, DelaysGrowToTheLongestAndAreForgotten) {
  Wall wall;
  TokenTries tries([&] { return wall.now; });
  for (int i = 0; i < TokenTries::kFreeTries; ++i) tries.note_wrong("ipv4:10.0.0.7", "supervisor");
  EXPECT_EQ(tries.wait_s("ipv4:10.0.0.7", "supervisor"), 0);
  for (const double wait_s : {0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8, 25.6, 51.2, 60.0, 60.0}) {
    tries.note_wrong("ipv4:10.0.0.7", "supervisor");
    EXPECT_NEAR(tries.wait_s("ipv4:10.0.0.7", "supervisor"), wait_s, 1e-6);
    EXPECT_EQ(tries.wait_s("ipv4:10.0.0.8", "supervisor"), 0);
    EXPECT_EQ(tries.wait_s("ipv4:10.0.0.7", "robot red1"), 0);
    wall.pass(wait_s + 0.001);
    EXPECT_EQ(tries.wait_s("ipv4:10.0.0.7", "supervisor"), 0);
  }
  wall.pass(TokenTries::kForgotten_s + 1);
  tries.note_wrong("ipv4:10.0.0.7", "supervisor");
  EXPECT_EQ(tries.wait_s("ipv4:10.0.0.7", "supervisor"), 0);
}

TEST(TokenTries, PortsAndNamesOfSocketsMakeNoOtherPeer) {
  EXPECT_EQ(peer_of("ipv4:10.0.0.7:51312"), peer_of("ipv4:10.0.0.7:51313"));
  EXPECT_NE(peer_of("ipv4:10.0.0.7:51312"), peer_of("ipv4:10.0.0.8:51312"));
  EXPECT_EQ(peer_of("unix:/tmp/a"), peer_of("unix:"));
}

struct Faults final : SimulationObserver {
  std::vector<SimulationEvent> all;
  void on_event(const SimulationEvent& event) override {
    if (event.kind == EventKind::fault) all.push_back(event);
  }
};

// A flood of wrong hellos is a few lines of the log, and no faster than the delays allow.
TEST(TokenTries, WrongHellosAreCountedAndSlowedDown) {
  Faults faults;
  LiveRun run(scenario_text(SEAM_SOURCE_DIR, 2, 1.0), {&faults});
  const auto try_token = [&](const std::string& robot, const std::string& token) {
    RawClient client(run.address);
    client.hello(robot, token);
    v1::ServerMessage message;
    while (client.read(message)) {
    }
    return client.finish();
  };
  for (int i = 0; i < TokenTries::kFreeTries + 1; ++i)
    EXPECT_EQ(try_token("r0", "guess").error_code(), grpc::StatusCode::UNAUTHENTICATED) << i;
  // Not even the right one is looked at now; another robot's is.
  const grpc::Status held = try_token("r0", "token-r0");
  EXPECT_EQ(held.error_code(), grpc::StatusCode::UNAVAILABLE);
  EXPECT_THAT(held.error_message(), HasSubstr("too many wrong ones from this peer"));
  EXPECT_EQ(try_token("r1", "guess").error_code(), grpc::StatusCode::UNAUTHENTICATED);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  std::vector<std::thread> clients;
  for (int robot = 0; robot < 2; ++robot) clients.push_back(good_client(run, robot, busy));
  run.start();
  run.wait();
  for (std::thread& client : clients) client.join();
  ASSERT_EQ(faults.all.size(), 2u);
  EXPECT_EQ(faults.all[0].robot, "r0");
  EXPECT_EQ(faults.all[0].detail, "102 clients were refused");  // Also who came too soon.
  EXPECT_EQ(faults.all[1].detail, "a client was refused");
}

// What a robot logs is bounded by simulated time; more is refused, with the budget named.
TEST(DebugBudget, WhatARobotLogsIsBoundedBySimulatedTime) {
  LiveRun run(scenario_text(SEAM_SOURCE_DIR, 1, 1.0));
  run.start();
  RawClient client(run.address);
  client.hello("r0", "token-r0");
  v1::ServerMessage message;
  int accepted = 0, refused = 0;
  while (client.read(message) && !message.has_goodbye()) {
    if (message.has_refusal()) {
      ++refused;
      EXPECT_EQ(message.refusal().field(), "debug");
      EXPECT_THAT(message.refusal().message(), HasSubstr("bytes a simulated second"));
      EXPECT_FALSE(message.refusal().decision_owed());
    }
    if (!message.has_observation()) continue;
    v1::Decision decision;
    decision.set_sequence(message.observation().sequence());
    for (int i = 0; i < WireLimits::kMaxDebugItems; ++i) {
      decision.add_debug()->set_name("x");
      decision.mutable_debug(i)->set_text(std::string(1000, 'x'));
    }
    client.decide(decision);
    ++accepted;
  }
  // One simulated second of 64 kB each 32 ms is 2 MB.
  EXPECT_GE(accepted, 20);
  EXPECT_GT(refused, accepted / 2);
  EXPECT_LT(refused, accepted);
}

}  // namespace
}  // namespace seam::scheduler
