// A listener that lives, whoever connects.
#include <gtest/gtest.h>

#include "scheduler/server/live_testing.h"
#include "scheduler/server/silent_connections.h"

namespace seam::scheduler {
namespace {

using namespace seam::scheduler::testing;  // NOLINT: helpers of this folder's tests.

// More than the descriptors that a program usually has, on a plain loopback address: a robot still
// gets in, and who says nothing is hung up on.
TEST(Listener, SilentConnectionsDoNotEndIt) {
  const UsualDescriptorLimit limit;
  if (!limit.can_be_raised_to(4096)) GTEST_SKIP() << "the system allows no more descriptors";
  const Scenario scenario =
      Scenario::from_text(scenario_text(SEAM_SOURCE_DIR, 1, 0.3), "test.yaml");
  World world(scenario);
  RunControl control;
  ClientHub hub(LiveRun::hub_robots(scenario), control);
  Server server({{"127.0.0.1:0"}, {}, "boss"}, scenario, world, hub, control);
  const SilentConnections silent(server.addresses()[0], 1100);
  ASSERT_EQ(silent.count(), 1100u);
  {
    RawClient client(server.addresses()[0]);
    client.hello("r0", "token-r0");
    v1::ServerMessage message;
    ASSERT_TRUE(client.read(message));
    EXPECT_TRUE(message.has_welcome());
  }
  EXPECT_TRUE(silent.hung_up_within(20));
}

}  // namespace
}  // namespace seam::scheduler
