#include "sim_core/body/kinematics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/world/robot.h"

namespace seam {
namespace {

const std::string kSource = SEAM_SOURCE_DIR;

RobotBody ers210() {
  RobotBody body;
  read_config(ConfigNode::from_file(kSource + "/models/robot_ers210.yaml"),
              [&](ConfigTable& t) { describe(t, body); });
  return body;
}

void expect_place(const Vec3& a, const Vec3& b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

// Values worked out by hand from the chain: tilt axis 75 mm forward and 50 mm up, roll centre 48 mm
// up the neck, camera 66.6 mm ahead.
TEST(HeadChain, MatchesHandComputedPoses) {
  const RobotBody body = ers210();
  const double quarter = 1.5707963267948966;
  const Pose straight = camera_link_pose(body, {0, 0, 0});
  expect_place(straight.p, {0.1416, 0, 0.098});
  // Pan 90 degrees to the left: the camera is to the left and looks along +y.
  const Pose left = camera_link_pose(body, {0, quarter, 0});
  expect_place(left.p, {0.075, 0.0666, 0.098});
  expect_place(left.R[0], {0, 1, 0});
  // Tilt 90 degrees up: the neck points backwards, the camera looks up.
  const Pose up = camera_link_pose(body, {quarter, 0, 0});
  expect_place(up.p, {0.075 - 0.048, 0, 0.05 + 0.0666});
  expect_place(up.R[0], {0, 0, 1});
  // Tilt down 30 degrees and pan 60 to the left: the pan axis leans forward with the neck.
  const Pose both = camera_link_pose(body, {-quarter / 3, quarter * 2 / 3, 0});
  const double c30 = std::sqrt(3.0) / 2, s30 = 0.5, c60 = 0.5, s60 = std::sqrt(3.0) / 2;
  const Vec3 ahead{c60 * c30, s60, -c60 * s30};
  expect_place(both.R[0], ahead);
  expect_place(both.p, Vec3(0.075, 0, 0.05) + 0.048 * Vec3(s30, 0, c30) + 0.0666 * ahead);
  // Roll about the optical axis moves nothing but the image's up.
  const Pose rolled = camera_link_pose(body, {0, 0, 0.4});
  expect_place(rolled.p, straight.p);
  expect_place(rolled.R[2], {0, -std::sin(0.4), std::cos(0.4)});
}

TEST(Legs, StraightLegReachesStraightDown) {
  const RobotBody body = ers210();
  const LegPose leg = leg_pose(body, 0, JointAngles{});
  expect_place(leg.p_BPaw, {0.065 + 0.009, 0.0625, -0.0695 - 0.0654});
  JointAngles out{};
  out[static_cast<size_t>(leg_joint(1, 1))] =
      1.5707963267948966;  // Right elevator: out to the right.
  expect_place(leg_pose(body, 1, out).p_BPaw, {0.074, -0.0625 - 0.1349, 0});
}

TEST(Legs, PositiveRotatorsMoveFrontPawsForwardAndHindPawsBackward) {
  const RobotBody body = ers210();
  JointAngles angles{};
  for (int leg = 0; leg < kLegs; ++leg) {
    const double before = leg_pose(body, leg, angles).p_BPaw.x;
    JointAngles turned = angles;
    turned[static_cast<size_t>(leg_joint(leg, 0))] = 0.3;
    EXPECT_GT(leg_side_x(leg) * (leg_pose(body, leg, turned).p_BPaw.x - before), 0.02);
  }
}

// A body of the given attitude on its paws: the attitude comes back.
TEST(AttitudeOnPaws, IsThatOfThePlaneThroughThem) {
  RobotBody body = ers210();
  const double pitch = 0.07, roll = -0.04, height = 0.12;
  const Mat3 R_WB = rotation_zyx(roll, pitch, 0);
  std::array<Vec3, kLegs> paws;
  for (int leg = 0; leg < kLegs; ++leg) {
    // The paw's centre is a paw's radius above the ground: solve for z in the body's frame.
    const double x = 0.07 * leg_side_x(leg), y = 0.06 * leg_side_y(leg);
    const double z = (body.paw_radius_m - height - R_WB[0].z * x - R_WB[1].z * y) / R_WB[2].z;
    paws[static_cast<size_t>(leg)] = {x, y, z};
  }
  const Attitude attitude = attitude_on_paws(body, paws);
  EXPECT_NEAR(attitude.pitch_rad, pitch, 1e-12);
  EXPECT_NEAR(attitude.roll_rad, roll, 1e-12);
  EXPECT_NEAR(attitude.height_m, height, 1e-12);
  // With one diagonal in the air the body stands on the other, as high as before.
  paws[0] += 0.02 * glm::transpose(R_WB)[2];
  paws[3] += 0.02 * glm::transpose(R_WB)[2];
  EXPECT_NEAR(attitude_on_paws(body, paws).height_m, height, 1e-3);
}

TEST(Body, HasTheSizeOfTheDataSheet) {
  const RobotBody body = ers210();
  const auto links = link_poses(body, JointAngles{});  // Straight legs, head ahead.
  Vec3 low{1.0}, high{-1.0};
  for (const BodyPart& part : body.parts) {
    const Pose X_BP =
        links[static_cast<size_t>(part.link)] *
        Pose{rotation_zyx(part.rotate_rad.x, part.rotate_rad.y, part.rotate_rad.z), part.centre_m};
    std::vector<std::pair<Vec3, Vec3>> boxes;  // Centre and half extents in the body's axes.
    if (part.shape == Shape::box) {
      Vec3 half{0.0};
      for (int i = 0; i < 3; ++i) half += 0.5 * part.size_m[i] * glm::abs(X_BP.R[i]);
      boxes.emplace_back(X_BP.p, half);
    } else {
      boxes.emplace_back(X_BP.p, Vec3(part.size_m.x));
      if (part.shape == Shape::capsule)
        boxes.emplace_back(X_BP * Vec3(0, 0, part.size_m.z), Vec3(part.size_m.x));
    }
    for (const auto& [centre, half] : boxes)
      low = glm::min(low, centre - half), high = glm::max(high, centre + half);
  }
  EXPECT_NEAR(high.y - low.y, 0.154, 0.001);  // Width, height and length of the data sheet.
  EXPECT_NEAR(high.z - low.z, 0.266, 0.001);
  EXPECT_NEAR(high.x - low.x, 0.274, 0.001);
}

}  // namespace
}  // namespace seam
