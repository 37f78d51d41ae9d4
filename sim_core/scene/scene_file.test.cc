#include "sim_core/scene/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/matrix.hpp>

#include "sim_core/base/error.h"
#include "sim_core/input/schema_testing.h"

namespace seam {
namespace {

std::unique_ptr<SceneSource> scene(const std::string& objects,
                                   const std::string& head = "shading: flat\n") {
  return read_scene(ConfigNode::from_text(
      "format: seam-scene/1\nbackground_rgb: [0.1, 0.2, 0.3]\n" + head + "objects:\n" + objects,
      "scene.yaml"));
}

std::string message_of(const std::string& objects, const std::string& head = "shading: flat\n") {
  try {
    scene(objects, head);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneFile, ObjectsMoveFromTheirPlaceAtTimeZero) {
  const auto source = scene(
      "  - {shape: sphere, centre_m: [1, 2, 3], radius_m: 0.1, rgb: [1, 0, 0], velocity_mps: [0, "
      "0.5, 0]}\n"
      "  - {shape: cylinder, base_m: [2, 1, 0], radius_m: 0.05, height_m: 0.4, rgb: [0, 1, 0]}\n");
  std::vector<Primitive> now;
  source->primitives_at(SimTime::from_s(2), now);
  ASSERT_EQ(now.size(), 2u);
  EXPECT_DOUBLE_EQ(now[0].X_WO.p.y, 3.0);
  EXPECT_EQ(now[1].shape, Shape::cylinder);
  EXPECT_DOUBLE_EQ(now[1].size.z, 0.4);
  EXPECT_DOUBLE_EQ(source->background()[2], 0.3);
}

TEST(SceneFile, BoardsAndCapsulesStandAsInScenarios) {
  const auto source = scene(
      "  - {shape: capsule, base_m: [0, 0, 0], radius_m: 0.1, height_m: 1, rgb: [1, 0, 0]}\n"
      "  - {shape: board, pattern: chessboard, columns: 3, rows: 2, pitch_m: 0.1, border_m: 0, "
      "pose: {x_m: 1, yaw_rad: 1.5707963267948966}, velocity_mps: [0, 0, 0.5]}\n");
  std::vector<Primitive> now;
  source->primitives_at(SimTime::from_s(2), now);
  ASSERT_EQ(now.size(), 5u);  // The ground and three dark squares of six.
  EXPECT_EQ(now[0].shape, Shape::capsule);
  // The square at the lower left, turned by a quarter and a metre up by now.
  EXPECT_NEAR(now[2].X_WO.p.x, 1.05, 1e-12);
  EXPECT_NEAR(now[2].X_WO.p.y, -0.1, 1e-12);
  EXPECT_NEAR(now[2].X_WO.p.z, 1, 1e-12);
}

TEST(SceneFile, RectanglesStandUprightWithALevelFirstSide) {
  const std::string rectangle =
      "  - {shape: rectangle, centre_m: [0, 0, 0], size_m: [4.2, 2.7], rgb: [1, 0, 0], normal: ";
  const auto source = scene(rectangle + "[0, 0, 1]}\n" + rectangle + "[2, 0, 0]}\n");
  std::vector<Primitive> now;
  source->primitives_at(SimTime(), now);
  EXPECT_DOUBLE_EQ(now[0].X_WO.R[0].x, 1);
  EXPECT_DOUBLE_EQ(now[0].X_WO.R[2].z, 1);
  EXPECT_DOUBLE_EQ(now[1].X_WO.R[2].x, 1);
  EXPECT_DOUBLE_EQ(now[1].X_WO.R[0].z, 0);
  EXPECT_DOUBLE_EQ(glm::determinant(now[1].X_WO.R), 1);
}

TEST(SceneFile, SchemaFileIsCurrent) {
  expect_page_is(std::string(SEAM_SOURCE_DIR) + "/docs/reference/schemas/scene.schema.json",
                 scene_schema());
}

TEST(SceneFile, BadInputIsNamed) {
  EXPECT_THAT(message_of("  - {shape: ball}\n"), testing::HasSubstr("sphere"));
  EXPECT_THAT(
      message_of("  - {shape: sphere, centre_m: [1, 2, 3], radius_m: -1, rgb: [1, 0, 0]}\n"),
      testing::HasSubstr("radius_m"));
  EXPECT_THAT(message_of("  - {shape: sphere, centre_m: [1, 2], radius_m: 1, rgb: [1, 0, 0]}\n"),
              testing::HasSubstr("centre_m"));
  EXPECT_THAT(
      message_of(
          "  - {shape: sphere, centre_m: [1, 2, 3], radius_m: 1, colour: red, rgb: [1, 0, 0]}\n"),
      testing::HasSubstr("colour"));
  EXPECT_THAT(message_of("  []\n", "shading: lambert\n"), testing::HasSubstr("light"));
}

}  // namespace
}  // namespace seam
