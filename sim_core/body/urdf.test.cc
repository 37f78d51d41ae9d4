#include "sim_core/body/urdf.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "sim_core/base/error.h"
#include "sim_core/scenario/scenario.h"

namespace seam {
namespace {

namespace fs = std::filesystem;

class Urdf : public testing::Test {
 protected:
  Urdf() : folder_(fs::path(testing::TempDir()) / "urdf") {
    fs::create_directories(folder_ / "meshes");
  }
  ~Urdf() override { fs::remove_all(folder_); }

  RobotBody read(const std::string& inside,
                 std::map<std::string, std::string> packages = {}) const {
    std::ofstream(folder_ / "robot.urdf") << "<robot name=\"r\">\n" << inside << "\n</robot>\n";
    return body_from_urdf({"robot.urdf", folder_.string(), ""}, packages);
  }
  std::string error_of(const std::string& inside,
                       std::map<std::string, std::string> packages = {}) const {
    try {
      read(inside, std::move(packages));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  void expect_error(const std::string& inside, const std::string& part) const {
    const std::string found = error_of(inside);
    EXPECT_NE(found.find(part), std::string::npos) << found;
    EXPECT_NE(found.find("robot.urdf, line "), std::string::npos) << found;
  }
  fs::path folder_;
};

std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                  const std::string& type = "fixed", const std::string& inside = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + inside + "</joint>\n";
}

TEST_F(Urdf, TheSampleArmStandsUpright) {
  RobotBody body = body_from_urdf({"arm.urdf", SEAM_SOURCE_DIR "/scenarios/arm", ""}, {});
  ASSERT_EQ(body.tree.connect(), std::nullopt);
  EXPECT_EQ(body.name, "small_arm");
  ASSERT_EQ(body.joint_count(), 5u);
  EXPECT_EQ(body.joint_name(2), "elbow");
  EXPECT_NEAR(body.mass_kg, 2.1, 1e-12);
  body.tree.camera_link = "camera";
  ASSERT_EQ(body.tree.connect(), std::nullopt);
  // 0.06 + 0.06 + 0.18 up, 0.15 + 0.02 ahead, 0.03 above the wrist; the camera looks down a little.
  const Pose X = body.tree.camera_link_pose({});
  EXPECT_NEAR(X.p.x, 0.17, 1e-12);
  EXPECT_NEAR(X.p.z, 0.33, 1e-12);
  EXPECT_NEAR(X.R[0].z, -std::sin(0.15), 1e-12);
}

TEST_F(Urdf, LinksAreOrderedFromTheRoot) {
  const RobotBody body = read("<link name=\"c\"/><link name=\"b\"/><link name=\"a\"/>" +
                              joint("second", "b", "c") + joint("first", "a", "b"));
  ASSERT_EQ(body.tree.links.size(), 3u);
  EXPECT_EQ(body.tree.links[0].name, "a");
  EXPECT_EQ(body.tree.links[2].name, "c");
}

TEST_F(Urdf, PartsAreWhereVisualsAre) {
  const RobotBody body = read(R"(<material name="m"><color rgba="1 0.5 0 1"/></material>
    <link name="a"><visual><origin xyz="0 0 1"/>
    <geometry><cylinder radius="0.1" length="0.4"/></geometry>
    <material name="m"/></visual></link>)");
  ASSERT_EQ(body.parts.size(), 1u);
  EXPECT_NEAR(body.parts[0].centre_m.z, 0.8, 1e-12);  // A cylinder of ours starts at its base.
  EXPECT_NEAR(body.parts[0].rgb[0], 1, 1e-12);
  EXPECT_NEAR(body.parts[0].rgb[1], 0.2140, 1e-3);  // sRGB's half is a fifth of the light.
}

TEST_F(Urdf, MeshesAreFoundInPackagesAndNowhereElse) {
  std::ofstream(folder_ / "meshes" / "a.stl") << "solid\nendsolid\n";
  const auto link = [](const std::string& file) {
    return "<link name=\"a\"><visual><geometry><mesh filename=\"" + file +
           "\"/></geometry></visual></link>";
  };
  EXPECT_EQ(read(link("meshes/a.stl")).parts[0].mesh.name, "meshes/a.stl");
  EXPECT_EQ(read(link("package://mine/a.stl"), {{"mine", "meshes"}}).parts[0].mesh.name,
            "meshes/a.stl");
  expect_error(link("package://mine/a.stl"), "no folder is known for the package 'mine'");
  expect_error(link("meshes/none.stl"), "found no file");
  expect_error(link("../a.stl"), "mesh '../a.stl'");
  expect_error(link("/etc/passwd"), "mesh '/etc/passwd'");
  expect_error(link("file:///etc/passwd"), "expected a path or package://");
}

TEST_F(Urdf, BadFilesAreNamedWithTheirLine) {
  const std::string two = "<link name=\"a\"/>\n<link name=\"b\"/>\n";
  expect_error(two, "expected one root");
  expect_error(two + joint("j", "a", "b") + joint("k", "b", "a"), "in a circle");
  expect_error(two + "<link name=\"c\"/>" + joint("j", "b", "c") + joint("k", "c", "b"),
               "in a circle");
  expect_error(two + joint("j", "a", "nobody"), "'nobody', which is not there");
  expect_error(two + joint("j", "a", "b") + joint("k", "a", "b"), "hangs on two joints");
  expect_error(two + joint("j", "a", "b", "floating"), "of type 'floating'");
  expect_error(two + joint("j", "a", "b", "revolute"), "has no <limit>");
  expect_error(two + joint("j", "a", "b", "revolute", "<limit lower=\"2\" upper=\"1\"/>"),
               "above upper");
  expect_error(two + joint("j", "a", "b", "fixed", "<origin xyz=\"0 nan 0\"/>"),
               "expected 3 finite");
  expect_error(two + joint("j", "a", "b", "fixed", "<origin xyz=\"0 0\"/>"), "found 2 numbers");
  expect_error("", "found no links");
  expect_error("<link", "found no XML");
  std::ofstream(folder_ / "robot.urdf") << "<robot name=\"r\" xmlns:xacro=\"x\"/>";
  EXPECT_THROW(body_from_urdf({"robot.urdf", folder_.string(), ""}, {}), InputError);
}

TEST_F(Urdf, AScenarioHoldsTheWholeRobot) {
  Scenario scenario = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/arm/arm.yaml");
  scenario.lighting = {};  // Its direction is made of length 1 anew each time.
  const std::string text = scenario.to_yaml();
  EXPECT_EQ(text.find("urdf"), std::string::npos);
  Scenario again = Scenario::from_text(text, "again");
  again.lighting = {};
  EXPECT_EQ(again.to_yaml(), text);
  ASSERT_EQ(again.robots[0].body.joint_count(), 5u);
  EXPECT_EQ(again.robots[0].body.parts.size(), scenario.robots[0].body.parts.size());
  const JointAngles joints{0.1, -0.2, 0.3, 0.4, 0.01};
  const Pose a = scenario.robots[0].body.tree.camera_link_pose(joints);
  const Pose b = again.robots[0].body.tree.camera_link_pose(joints);
  EXPECT_EQ(a.p, b.p);
  EXPECT_EQ(a.R, b.R);
}

}  // namespace
}  // namespace seam
