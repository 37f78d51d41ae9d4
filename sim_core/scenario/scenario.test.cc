#include "sim_core/scenario/scenario.h"

#include <gtest/gtest.h>

#include "sim_core/base/error.h"
#include "sim_core/input/schema_testing.h"
#include "sim_core/scene/scene_file.h"
#include "sim_core/world/world.h"

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
  EXPECT_NE(error_of(head + "robots:\n" + robot + robot).find("found two robots with the id 'a'"),
            std::string::npos);
  EXPECT_NE(error_of(head + "robots:\n  - {id: a, team: red, pose: {x_m: 0, y_m: 0}}\n")
                .find("robot without a body"),
            std::string::npos);
  EXPECT_NE(error_of("format: seam-model/1\n").find("seam-scenario/1"), std::string::npos);
}

// The same objects in a scene of a measurement set and in a scenario look the same.
TEST(Scenario, ObjectsAreThoseOfSceneFiles) {
  const std::string objects =
      "objects:\n"
      "  - {shape: rectangle, centre_m: [1, 2, 3], size_m: [4.2, 2.7], normal: [1, 1, 0.5], rgb: "
      "[0.1, 0.2, 0.3]}\n"
      "  - {shape: sphere, centre_m: [0.8, 0.1, 0.042], radius_m: 0.042, rgb: [0.9, 0.3, 0.02], "
      "velocity_mps: [0, 0.5, 0]}\n"
      "  - {shape: cylinder, base_m: [2.2, 1.45, 0.0], radius_m: 0.05, height_m: 0.4, rgb: [0.9, "
      "0.4, 0.5]}\n"
      "  - {shape: box, centre_m: [1.5, -0.5, 0.1], size_m: [0.27, 0.15, 0.2], yaw_rad: 0.4, rgb: "
      "[0.2, 0.2, 0.2]}\n";
  const auto scene = read_scene(ConfigNode::from_text(
      "format: seam-scene/1\nbackground_rgb: [0, 0, 0]\n" + objects, "scene"));
  const std::string rest =
      "format: seam-scenario/1\nduration_s: 1\nhas_field: false\nball: {present: false}\n";
  const Scenario scenario = Scenario::from_text(rest + objects, "scenario");
  const World world(Scenario::from_text(scenario.to_yaml(), "copy"));
  std::vector<Primitive> expected, found;
  scene->primitives_at(SimTime::from_s(0.3), expected);
  world.primitives_at(SimTime::from_s(0.3), found);
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].shape, expected[i].shape);
    EXPECT_EQ(found[i].rgb, expected[i].rgb);
    EXPECT_EQ(found[i].size.x, expected[i].size.x);
    EXPECT_LT(glm::length(found[i].X_WO.p - expected[i].X_WO.p), 1e-12);
    for (int axis = 0; axis < 3 && found[i].shape != Shape::sphere; ++axis) {
      EXPECT_LT(glm::length(found[i].X_WO.R[axis] - expected[i].X_WO.R[axis]), 1e-12) << i;
    }
  }
}

TEST(Scenario, ShippedScenariosAreValid) {
  for (const auto& entry : std::filesystem::directory_iterator(kSource + "/scenarios")) {
    // Plans of sweeps stand beside the scenarios that they name.
    if (entry.path().extension() != ".yaml" || entry.path().filename() == "sweep.yaml") continue;
    EXPECT_NO_THROW(Scenario::from_file(entry.path())) << entry.path();
  }
}

TEST(Scenario, SchemaFileIsCurrent) {
  expect_page_is(kSource + "/docs/reference/schemas/scenario.schema.json", Scenario::schema());
}

}  // namespace
}  // namespace seam
