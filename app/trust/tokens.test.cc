#include "app/trust/tokens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/simulator.h"

namespace seam::app {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kSecrets[] = {"robot-secret-1", "supervisor-secret-2", "render-secret-3"};

Scenario with_secrets() {
  Scenario scenario = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/head_swing.yaml");
  scenario.robots[0].token = kSecrets[0];
  scenario.supervisor_token = kSecrets[1];
  scenario.render_token = kSecrets[2];
  return scenario;
}

TEST(Tokens, AreNotInTheHeaderOfALog) {
  const Simulator simulator = make_simulator(with_secrets());
  EXPECT_EQ(simulator.scenario.robots[0].token, kSecrets[0]);  // Clients still connect with it.
  for (const char* secret : kSecrets)
    EXPECT_THAT(simulator.header.scenario_text, Not(HasSubstr(secret)));
  // `printf robot-secret-1 | sha256sum` begins so.
  EXPECT_THAT(simulator.header.scenario_text, HasSubstr("fingerprint-7456216a"));
}

TEST(Tokens, OfALogOpenNothingInALaterRun) {
  const Simulator first = make_simulator(with_secrets());
  const Simulator again = make_simulator(first.header);
  EXPECT_EQ(again.scenario.robots[0].token, "");
  EXPECT_EQ(again.scenario.supervisor_token, "");
  EXPECT_EQ(again.scenario.render_token, "");
  EXPECT_EQ(again.header.scenario_text, first.header.scenario_text);
}

TEST(Tokens, OfOlderLogsAreNotShown) {
  const std::string old_text = with_secrets().to_yaml();
  const std::string text = shown_scenario(old_text, "old");
  for (const char* secret : kSecrets) EXPECT_THAT(text, Not(HasSubstr(secret)));
  EXPECT_EQ(shown_scenario(text, "new"), text);
  EXPECT_THAT(shown_scenario("robots: [{token: robot-secret-1", "damaged"),
              Not(HasSubstr(kSecrets[0])));
}

}  // namespace
}  // namespace seam::app
