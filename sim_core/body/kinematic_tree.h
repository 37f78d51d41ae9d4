// A robot of any build: links joined by joints, as URDF describes them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim_core/base/pose.h"
#include "sim_core/body/actuator.h"
#include "sim_core/body/joints.h"
#include "sim_core/input/config_table.h"

namespace seam {

enum class JointMotion : uint8_t {
  fixed,
  turn,   // About the axis, rad.
  slide,  // Along the axis; what are angles elsewhere are metres here.
};

// A link and the joint that holds it. The root has none and stands first.
struct TreeLink {
  std::string name;
  std::string parent;  // A link before this one; empty for the root.
  std::string joint;   // The joint's name; a fixed one needs none.
  JointMotion motion = JointMotion::fixed;
  Vec3 translate_m{0.0};  // X_PJ: the joint's frame in the parent's, which is the link's at 0.
  Vec3 rotate_rad{0.0};   // Rz(z) Ry(y) Rx(x).
  Vec3 axis{1, 0, 0};     // In the joint's frame.
  JointLimits limits;
  double start_rad = 0;
  // Follows another joint: factor * its angle + offset.
  std::string mimics;
  double mimic_factor = 1;
  double mimic_offset_rad = 0;
};

class KinematicTree {
 public:
  std::vector<TreeLink> links;
  // The camera: x along the optical axis, y left, z up, in the frame of its link.
  std::string camera_link;  // Empty: the root.
  Vec3 camera_translate_m{0.0};
  Vec3 camera_rotate_rad{0.0};
  bool sees_own_link = false;  // Whether the camera's link is in its own pictures.

  bool present() const { return !links.empty(); }
  // Finds what names lead to; what is wrong with them, or nothing. To be called after each change.
  std::optional<std::string> connect();

  // Joints that can be commanded, in the order of their links.
  size_t joint_count() const { return driven_.size(); }
  const TreeLink& joint(size_t number) const { return links[driven_[number]]; }
  std::optional<size_t> joint_called(std::string_view name) const;
  size_t camera_place() const { return camera_place_; }
  // X_BLink of each link; the body's frame is the root's.
  std::vector<Pose> link_poses(const JointAngles& joints) const;
  Pose camera_link_pose(const JointAngles& joints) const;
  // No link's origin is ever farther from the root's, m.
  double reach_m() const;
  // No point within `reach_m` of all axes before it moves further between these angles.
  double motion_bound_m(const JointAngles& a, const JointAngles& b, double reach_m) const;

 private:
  struct Connection {
    size_t parent = 0;
    size_t joint = 0;  // Number of the joint that drives it, its own or the one that it mimics.
    Pose X_PJ;
    Vec3 axis{1, 0, 0};  // Of length 1.
  };
  std::optional<std::string> hang(size_t place);
  std::optional<std::string> drive(size_t place);
  double angle_of(size_t place, const JointAngles& joints) const;
  Pose moved(size_t place, const JointAngles& joints) const;

  std::vector<Connection> connections_;  // By link.
  std::vector<size_t> driven_;           // Links of the joints that can be commanded.
  size_t camera_place_ = 0;
  Pose X_LinkCamera_;
};

// The tree's links.
void describe(ConfigTable& table, TreeLink& link);

}  // namespace seam
