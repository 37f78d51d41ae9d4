// A robot as pictures show it: its body file's parts, wherever its posture puts them.
#pragma once

#include <vector>

#include "sim_core/body/kinematics.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/scene/scene.h"

namespace seam {

// X_WB of a posture.
Pose body_pose_of(const Posture& posture);

class RobotFigure final : public Figure {
 public:
  // What holds the camera is not in its own pictures.
  enum class Parts : uint8_t { all, before_own_lens };
  // `spec` must outlive it.
  RobotFigure(const RobotSpec& spec, uint16_t object_id, Parts parts);

  size_t part_count() const override { return parts_.size(); }
  void add_parts(const Posture& posture, std::vector<Primitive>& out) const override;
  double radius_m() const override { return radius_m_; }
  std::string part_name(size_t part) const override;
  double motion_bound_m(const Posture& a, const Posture& b) const override;

 private:
  struct Part {
    const BodyPart* part;
    Primitive on_link;  // X_WO is its pose on the link.
  };
  double joints_motion_bound_m(const JointAngles& a, const JointAngles& b) const;

  const RobotBody* body_;
  std::vector<Part> parts_;
  double radius_m_ = 0;
  // No point that a chain of joints moves is farther from any of its axes: the head's, a leg's, or
  // that of a tree of links.
  double head_reach_m_ = 0, leg_reach_m_ = 0, tree_reach_m_ = 0;
};

}  // namespace seam
