#include "sim_core/body/urdf.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

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
  expect_error(two + joint("j", "a", "b", "continuous", "<limit velocity=\"-1\"/>"),
               "velocity=\"-1\": expected at least 0");
  expect_error("<link name=\"a\"><inertial><mass value=\"-5\"/></inertial></link>",
               "value=\"-5\": expected at least 0");
  expect_error("", "found no links");
  expect_error("<link", "found no XML");
}

// xacro leaves its namespace on what it has expanded.
TEST_F(Urdf, OnlyWhatIsNotExpandedIsXacro) {
  const auto why_not = [&](const std::string& inside) -> std::string {
    std::ofstream(folder_ / "robot.urdf")
        << "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n"
        << inside << "</robot>";
    try {
      body_from_urdf({"robot.urdf", folder_.string(), ""}, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const std::string link = "<link name=\"a\"/>\n";
  EXPECT_EQ(why_not(link + "<!-- <xacro:arm/> ${width} -->"), "");
  EXPECT_EQ(why_not("<link name=\"a\"><collision name=\"$5\"/></link>"), "");
  for (const auto& [inside, found] : std::vector<std::pair<std::string, std::string>>{
           {link + "<xacro:property name=\"w\" value=\"1\"/>", "line 3: found <xacro:property>"},
           {"<link name=\"a\">\n<xacro:if value=\"1\"/></link>", "line 3: found <xacro:if>"},
           {link + "<link name=\"${side}_b\"/>", "line 3: found '${side}_b'"},
           {link + "<gazebo><file>$(find arm)/a.yaml</file></gazebo>", "'$(find arm)/a.yaml'"}}) {
    EXPECT_NE(why_not(inside).find(found), std::string::npos) << why_not(inside);
    EXPECT_NE(why_not(inside).find("expand it with `xacro FILE`"), std::string::npos);
  }
}

TEST_F(Urdf, ShapesWithoutVolumeAreLeftOutAndSaid) {
  const auto link = [](const std::string& shape) {
    return "<link name=\"hand\">\n<visual><geometry>" + shape + "</geometry></visual></link>";
  };
  for (const char* shape :
       {"<box size=\"0 0 0\"/>", "<box size=\"0.1 0 0.1\"/>", "<sphere radius=\"0\"/>",
        "<cylinder radius=\"0\" length=\"1\"/>", "<cylinder radius=\"0.1\" length=\"0.0\"/>",
        "<mesh filename=\"none.stl\" scale=\"0 0 0\"/>"}) {
    const RobotBody body = read(link(shape));
    EXPECT_TRUE(body.parts.empty()) << shape;
    ASSERT_EQ(body.notes.size(), 1u) << shape;
    EXPECT_NE(body.notes[0].find("robot.urdf, line 3: the shape of link 'hand' has no volume"),
              std::string::npos)
        << body.notes[0];
  }
  EXPECT_EQ(read(link("<box size=\"1 1 1\"/>")).notes.size(), 0u);
  expect_error(link("<box size=\"1 -1 1\"/>"), "an edge of -1, expected at least 0");
  expect_error(link("<box/>"), "<box> has no size");
  expect_error(link("<sphere radius=\"-1\"/>"), "expected at least 0");
  expect_error(link("<sphere/>"), "<sphere> has no radius");
}

TEST_F(Urdf, HumanoidsHaveSixtyFourJoints) {
  const auto chain = [](int joints) {
    std::string text = "<link name=\"l0\"/>";
    for (int i = 1; i <= joints; ++i)
      text += "<link name=\"l" + std::to_string(i) + "\"/>" +
              joint("j" + std::to_string(i), "l" + std::to_string(i - 1), "l" + std::to_string(i),
                    "continuous");
    return text;
  };
  RobotBody body = read(chain(64));
  EXPECT_EQ(body.tree.connect(), std::nullopt);
  EXPECT_EQ(body.joint_count(), 64u);
  EXPECT_EQ(body.joint_name(63), "j64");
  body = read(chain(65));
  EXPECT_NE(body.tree.connect().value_or("").find("more than 64 joints"), std::string::npos);
}

TEST_F(Urdf, AScenarioHoldsTheWholeRobot) {
  const Scenario scenario = Scenario::from_file(SEAM_SOURCE_DIR "/scenarios/arm/arm.yaml");
  const std::string text = scenario.to_yaml();
  EXPECT_EQ(text.find("urdf"), std::string::npos);
  const Scenario again = Scenario::from_text(text, "again");
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
