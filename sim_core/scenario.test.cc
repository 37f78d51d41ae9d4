#include "sim_core/scenario.h"

#include <gtest/gtest.h>

#include "sim_core/error.h"
#include "sim_core/files.h"

namespace seam {
namespace {

const std::string kSource = SEAM_SOURCE_DIR;

TEST(Scenario, WrittenScenarioReadsBackToTheSameText) {
  const Scenario scenario = Scenario::from_file(kSource + "/scenarios/head_swing.yaml");
  ASSERT_EQ(scenario.robots.size(), 1u);
  EXPECT_EQ(scenario.robots[0].id, "red1");
  EXPECT_NE(scenario.robots[0].camera.model_yaml.find("rolling_shutter"), std::string::npos);
  const std::string yaml = scenario.to_yaml();
  EXPECT_EQ(Scenario::from_text(yaml, "copy").to_yaml(), yaml);
}

TEST(Scenario, ErrorsNameFileLineAndKey) {
  const auto error_of = [](const std::string& yaml) {
    try {
      Scenario::from_text(yaml, "s.yaml");
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  const std::string head = "format: seam-scenario/1\nduration_s: 1\n";
  EXPECT_EQ(error_of(head + "sede: 3\n"), "s.yaml:3: unknown key 'sede', did you mean 'seed'?");
  EXPECT_EQ(error_of("format: seam-scenario/1\nduration_s: 0\n"),
            "s.yaml:2: duration_s: found 0, expected a number from 0.001 to 1000000");
  EXPECT_NE(error_of(head + "field: nowhere.yaml\n").find("s.yaml:3: field: "), std::string::npos);
  const std::string body = "body: '" + kSource + "/models/robot_ers210.yaml'";
  const std::string robot = "  - {id: a, team: red, pose: {x_m: 0, y_m: 0}, " + body + "}\n";
  EXPECT_NE(error_of(head + "robots:\n" + robot + robot).find("found two robots with the id 'a'"), std::string::npos);
  EXPECT_NE(error_of(head + "robots:\n  - {id: a, team: red, pose: {x_m: 0, y_m: 0}}\n").find("robot without a body"),
            std::string::npos);
  EXPECT_NE(error_of("format: seam-model/1\n").find("seam-scenario/1"), std::string::npos);
}

TEST(Scenario, SchemaFileIsCurrent) {
  const std::string path = kSource + "/docs/scenario.schema.json";
  const std::string current = Scenario::schema();
  std::string checked_in;
  try {
    checked_in = read_file(path);
  } catch (const InputError&) {
  }
  if (current != checked_in) write_file_atomically(path + ".new", current);
  EXPECT_TRUE(current == checked_in) << "compare " << path << " with " << path << ".new";
}

}  // namespace
}  // namespace seam
