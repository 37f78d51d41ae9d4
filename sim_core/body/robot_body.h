// A kind of robot: its kinematics, limits, gait and looks, read from a file of format
// seam-robot/1 (models/robot_ers210.yaml) or from URDF. An ERS-210 has a head and four legs; any
// other robot is a tree of links, whose joints take the places of joints.h from 0 on.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "sim_core/body/actuator.h"
#include "sim_core/body/command.h"
#include "sim_core/body/joints.h"
#include "sim_core/body/kinematic_tree.h"
#include "sim_core/input/config_table.h"
#include "sim_core/scene/scene.h"

namespace seam {

// Links of an ERS-210 that parts are fixed to. The neck turns with tilt, the head with tilt, pan
// and roll.
enum class Link : uint8_t {
  body,
  neck,
  head,
  left_front_upper,
  left_front_lower,
  right_front_upper,
  right_front_lower,
  left_hind_upper,
  left_hind_lower,
  right_hind_upper,
  right_hind_lower,
};
inline constexpr int kLinks = 11;

// The robot's own colour, its team's uniform, or the part's own.
enum class Paint : uint8_t { body, team, own };

struct BodyPart {
  size_t link = 0;  // As Link counts; of a tree its place there.
  Shape shape = Shape::box;
  Vec3 centre_m{0.0};    // In the link's frame; capsules and cylinders start here.
  Vec3 rotate_rad{0.0};  // Rz(z) Ry(y) Rx(x).
  Vec3 size_m{0.1};      // As Primitive::size.
  Paint paint = Paint::body;
  Rgb rgb{1, 1, 1};  // Its own; of a mesh a factor on its file's colours.
  FileName mesh;
  double scale = 1;    // Of a mesh: metres for a unit of its file.
  uint32_t asset = 0;  // As Primitive::asset; whoever reads meshes sets it, and the size.
};

struct Gait {
  double step_s = 0.6;  // Duration of a whole stride.
  double max_vx_mps = 0.3;
  double max_vy_mps = 0.2;
  double max_omega_radps = 2.0;
  double stance_rotator_rad = -0.6;
  double stance_elevator_rad = 0.1;
  double stance_knee_rad = 1.2;
  double lift_knee_rad = 0.5;  // Extra bend of the knee in mid-swing.
  double settle_s = 0.15;      // Time constant with which strides grow and fade.
};

// A box in the body's frame, seen from above.
struct Reach {
  double min_x_m = 0, max_x_m = 0;
  double min_y_m = 0, max_y_m = 0;
};

// From `at_s` after the kick's start, this joint goes to this angle.
struct KickMotion {
  double at_s = 0;
  size_t joint = 0;  // joints.h
  double angle_rad = 0;
};

struct KickSpec {
  double duration_s = 0;     // The robot stands still for so long.
  double impact_s = 0;       // When the ball is hit.
  Reach reach;               // Where the ball's centre must be then.
  double speed_mps = 0;      // What the ball gets.
  double direction_rad = 0;  // From straight ahead, counter-clockwise.
  double speed_sigma = 0;    // Relative.
  double direction_sigma_rad = 0;
  std::vector<KickMotion> motion;
};

struct RobotBody {
  std::string name = "robot";
  std::vector<std::string> notes;  // Warnings of the reader: what of its file is left out.
  KinematicTree tree;
  // Of a tree: whether walk commands move its base, and how high the root's frame is over ground.
  bool moves = false;
  double base_height_m = 0;
  double mass_kg = 1.5;
  // Head chain (X_BL): translate to the tilt axis, tilt, pan, up to the roll centre, roll, forward
  // to the camera.
  Vec3 tilt_axis_m{0.075, 0, 0.05};
  double roll_height_m = 0.048;
  double camera_forward_m = 0.0666;
  std::array<JointLimits, kMostJoints> joints;
  // Legs.
  double shoulder_x_m = 0.065;
  double shoulder_y_m = 0.0625;
  double upper_leg_m = 0.0695;
  double upper_leg_offset_m = 0.009;
  double lower_front_m = 0.0654;
  double lower_hind_m = 0.0676;
  double paw_radius_m = 0.01395;
  Gait gait;
  // For collisions: a box.
  double footprint_length_m = 0.2;
  double footprint_width_m = 0.154;
  double footprint_x_m = 0.0;  // Centre of the footprint, forward of the body's origin.
  // Kicks by Kick - 1: leg_forward, leg_left, leg_right, head_left, head_right.
  std::array<KickSpec, 5> kicks;
  Reach grab;              // Where a ball can be grabbed.
  double hold_x_m = 0.15;  // Where a held ball's centre is, forward of the body's origin.
  // The kick's values; those of no duration for `none`, `grab` and `release`.
  const KickSpec& kick(Kick kick) const;

  size_t joint_count() const { return tree.present() ? tree.joint_count() : kJoints; }
  std::string joint_name(size_t joint) const;
  // Whether the body stands on it: a leg moves from a world step's end on.
  bool is_leg(int joint) const { return !tree.present() && joint >= kHeadJoints; }
  Rgb body_rgb{0.5, 0.5, 0.52};
  Rgb red_rgb{0.55, 0.02, 0.03};
  Rgb blue_rgb{0.02, 0.03, 0.3};
  std::vector<BodyPart> parts;
};

// As files call it.
const std::string& shape_name(Shape shape);

void describe(ConfigTable& table, RobotBody& body);

}  // namespace seam
