#include "app/scenario_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/simulator.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

const std::string kSource = SEAM_SOURCE_DIR;

Scenario head_swing() {
  return Scenario::from_file(kSource + "/scenarios/head_swing.yaml");
}

std::string why_not(const std::string& path, const std::string& value) {
  ScenarioTree tree(head_swing());
  try {
    tree.set(path, {value});
    tree.scenario();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

double value_in_model(const Scenario& scenario, const char* effect, const char* parameter) {
  return models_of(scenario).front().find(effect)->value(parameter);
}

TEST(ScenarioTree, NothingChangedIsTheSameScenario) {
  const Scenario scenario = head_swing();
  EXPECT_EQ(ScenarioTree(scenario).scenario().to_yaml(), scenario.to_yaml());
}

TEST(ScenarioTree, KeysChangeByPath) {
  ScenarioTree tree(head_swing());
  tree.set("duration_s", {"0.25"});
  tree.set("robots[0].pose.x_m", {"-1.5"});
  tree.set("robots[red1].head_rad[1]", {"0.125"});
  tree.set("robots[*].camera.every_frame", {"false"});
  tree.set("robots[0].behaviour.command", {"[head_swing, --rate, '20']", false});
  tree.set("robots[0].behaviour.command[2]", {"21"});
  const Scenario scenario = tree.scenario();
  EXPECT_EQ(scenario.duration, SimDuration::from_s(0.25));
  const RobotSpec& robot = scenario.robots[0];
  EXPECT_EQ(robot.pose.x_m, -1.5);
  EXPECT_EQ(robot.head_rad[1], 0.125);
  EXPECT_FALSE(robot.camera.every_frame);
  EXPECT_THAT(robot.behaviour.command, testing::ElementsAre("head_swing", "--rate", "21"));
}

TEST(ScenarioTree, PathsGoIntoModelsThatTheScenarioNamesByFile) {
  ScenarioTree tree(head_swing());
  const std::string model = "robots[0].camera.model.effects.";
  tree.set(model + "rolling_shutter.line_delay_s", {"1e-4"});
  tree.set(model + "frame_latency.latency_s", {"0.02"});  // Not in the file.
  tree.set(model + "exposure", {"{exposure_s: 0.001}", false});
  const Scenario scenario = tree.scenario();
  EXPECT_EQ(value_in_model(scenario, "rolling_shutter", "line_delay_s"), 1e-4);
  EXPECT_EQ(value_in_model(scenario, "frame_latency", "latency_s"), 0.02);
  EXPECT_EQ(value_in_model(scenario, "exposure", "exposure_s"), 0.001);
}

TEST(ScenarioTree, ANumberChangesTheValueAndLeavesItsSpread) {
  ScenarioTree tree(head_swing());
  tree.set("robots[0].camera.model.effects.white_balance.red_gain", {"1.5"});
  EXPECT_THAT(tree.scenario().to_yaml(), testing::HasSubstr("value: 1.5"));
  EXPECT_THAT(tree.scenario().to_yaml(), testing::HasSubstr("spread: 0.02"));
}

TEST(ScenarioTree, ACopyIsATreeOfItsOwn) {
  const ScenarioTree first(head_swing());
  ScenarioTree second(first);
  second.set("seed", {"7"});
  EXPECT_EQ(first.scenario().seed, 1);
  EXPECT_EQ(second.scenario().seed, 7);
}

TEST(ScenarioTree, UnknownKeysAreToldWithTheNearestKnownOne) {
  EXPECT_THAT(why_not("duratoin_s", "1"), testing::HasSubstr("did you mean 'duration_s'?"));
  EXPECT_THAT(why_not("robots[0].camra.every_frame", "1"), testing::HasSubstr("'camera'"));
  EXPECT_THAT(why_not("robots[rod1].pose.x_m", "1"), testing::HasSubstr("'red1'"));
  EXPECT_THAT(why_not("robots[3].pose.x_m", "1"), testing::HasSubstr("the list has 1 items"));
  EXPECT_THAT(why_not("robots.pose", "1"), testing::HasSubstr("no keys of its own"));
  EXPECT_THAT(why_not("duration_s.x", "1"), testing::HasSubstr("no keys of its own"));
  EXPECT_THAT(why_not("duration_s[0]", "1"), testing::HasSubstr("no list"));
  EXPECT_THAT(why_not("robots[0]", "1"), testing::HasSubstr("expected a map"));
  EXPECT_THAT(why_not("robot_defaults.camera.every_frame", "1"), testing::HasSubstr("robots[*]"));
  EXPECT_THAT(why_not("[0]", "1"), testing::HasSubstr("expected keys joined"));
  EXPECT_THAT(why_not("robots[0", "1"), testing::HasSubstr("expected keys joined"));
  EXPECT_THAT(why_not("", "1"), testing::HasSubstr("expected keys joined"));
  EXPECT_THAT(why_not("duration_s", "long"), testing::HasSubstr("expected a number"));
}

TEST(ScenarioTree, UnknownEffectsAreToldByTheModelsReader) {
  ScenarioTree tree(head_swing());
  tree.set("robots[0].camera.model.effects.rolling_shuter.line_delay_s", {"1e-4"});
  try {
    models_of(tree.scenario());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean 'rolling_shutter'?"));
  }
}

TEST(ScenarioTree, FilesStandWhereMapsDo) {
  const ScenarioTree tree(head_swing());
  EXPECT_TRUE(tree.takes_file("robots[0].camera.model"));
  EXPECT_TRUE(tree.takes_file("robots[0].camera.colour_table"));  // None is given.
  EXPECT_TRUE(tree.takes_file("field"));
  EXPECT_FALSE(tree.takes_file("duration_s"));
  EXPECT_FALSE(tree.takes_file("robots[0].camera.model.effects.white_balance.red_gain"));
  const auto changed = changed_scenario(
      head_swing(), {{"robots[0].camera.model", {kSource + "/models/ideal_camera.yaml"}}}, ".");
  EXPECT_FALSE(models_of(changed).front().has("rolling_shutter"));
}

TEST(ScenarioTree, ChangesOfACommandLine) {
  const ScenarioChange change = change_from_text("robots[0].pose.x_m=-1=2");
  EXPECT_EQ(change.path, "robots[0].pose.x_m");
  EXPECT_EQ(change.value, (WrittenValue{"-1=2"}));
  EXPECT_FALSE(change_from_text("a=[1, 2]").value.plain);
  EXPECT_THROW(change_from_text("a"), UsageError);
  EXPECT_THROW(change_from_text("=1"), UsageError);
  EXPECT_THROW(change_from_text("a=[1, 2"), InputError);
}

}  // namespace
}  // namespace seam::app
