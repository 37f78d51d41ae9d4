#include "sim_core/body/kinematic_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/maths.h"

namespace seam {
namespace {

constexpr double kQuarter = maths::kPi / 2;

TreeLink turning(const std::string& name, const std::string& parent, Vec3 place, Vec3 axis) {
  return {.name = name,
          .parent = parent,
          .joint = name + "_joint",
          .motion = JointMotion::turn,
          .translate_m = place,
          .axis = axis,
          .limits = {-3, 3, 1}};
}

void expect_near(const Vec3& found, const Vec3& expected) {
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], expected[k], 1e-12) << "axis " << k;
}

// Two links of 1 m in a plane: the law of cosines and the sum of angles.
TEST(KinematicTree, APlanarArmIsWhereTrigonometrySays) {
  KinematicTree tree;
  tree.links = {{.name = "base"},
                turning("upper", "base", {0, 0, 0}, {0, 0, 2}),
                turning("lower", "upper", {1, 0, 0}, {0, 0, 1}),
                {.name = "hand", .parent = "lower", .translate_m = {1, 0, 0}}};
  tree.camera_link = "hand";
  ASSERT_EQ(tree.connect(), std::nullopt);
  ASSERT_EQ(tree.joint_count(), 2u);
  for (const double a : {-1.2, 0.0, 0.7}) {
    for (const double b : {-2.0, 0.3, 1.9}) {
      const JointAngles joints{a, b};
      const Pose X = tree.link_poses(joints)[3];
      expect_near(X.p, {std::cos(a) + std::cos(a + b), std::sin(a) + std::sin(a + b), 0});
      expect_near(X.R[0], {std::cos(a + b), std::sin(a + b), 0});
      EXPECT_NEAR(glm::length(X.p), std::sqrt(2 + 2 * std::cos(b)), 1e-12);
      expect_near(tree.camera_link_pose(joints).p, X.p);
    }
  }
  EXPECT_NEAR(tree.reach_m(), 2, 1e-12);
}

TEST(KinematicTree, OriginsTurnBeforeJointsMove) {
  KinematicTree tree;
  tree.links = {{.name = "base"}, turning("arm", "base", {0, 0, 1}, {0, 0, 1})};
  tree.links[1].rotate_rad = {kQuarter, 0, 0};  // The joint's z is the base's -y.
  ASSERT_EQ(tree.connect(), std::nullopt);
  const Pose X = tree.link_poses({0.4})[1];
  expect_near(X.p, {0, 0, 1});
  expect_near(X.R[0], {std::cos(0.4), 0, std::sin(0.4)});
}

TEST(KinematicTree, SlidesAndMimics) {
  KinematicTree tree;
  TreeLink slide{.name = "left",
                 .parent = "base",
                 .joint = "gripper",
                 .motion = JointMotion::slide,
                 .translate_m = {0.1, 0, 0},
                 .axis = {0, 3, 0},
                 .limits = {0, 0.05, 1}};
  TreeLink other = slide;
  other.name = "right", other.joint = "gripper_right", other.mimics = "gripper";
  other.mimic_factor = -2, other.mimic_offset_rad = 0.01;
  // The one that mimics may stand before the one that it follows.
  tree.links = {{.name = "base"}, other, slide};
  ASSERT_EQ(tree.connect(), std::nullopt);
  ASSERT_EQ(tree.joint_count(), 1u);
  EXPECT_EQ(tree.joint(0).joint, "gripper");
  const auto X = tree.link_poses({0.03});
  expect_near(X[2].p, {0.1, 0.03, 0});
  expect_near(X[1].p, {0.1, -2 * 0.03 + 0.01, 0});
}

TEST(KinematicTree, SaysWhatIsWrong) {
  const auto wrong = [](std::vector<TreeLink> links) {
    KinematicTree tree;
    tree.links = std::move(links);
    return tree.connect().value_or("");
  };
  const TreeLink base{.name = "base"};
  EXPECT_NE(wrong({base, turning("a", "nobody", {}, {1, 0, 0})}).find("'nobody'"),
            std::string::npos);
  EXPECT_NE(wrong({base, turning("a", "base", {}, {0, 0, 0})}).find("no length"),
            std::string::npos);
  EXPECT_NE(wrong({base, base}).find("two links"), std::string::npos);
  EXPECT_NE(wrong({{.name = "a\x1b[2J"}}).find("\\x1b"), std::string::npos);
  std::vector<TreeLink> many{base};
  for (int i = 0; i <= kMostJoints; ++i)
    many.push_back(turning("l" + std::to_string(i), "base", {}, {1, 0, 0}));
  EXPECT_NE(wrong(many).find("more than 64"), std::string::npos);
}

}  // namespace
}  // namespace seam
