#include "tools/viewer/joint_series.h"

#include "sim_core/base/maths.h"

namespace seam::tools {

void add_joint_series(app::ReplayMatch& match, ViewIndex& index) {
  const std::vector<RobotSpec>& robots = match.scenario().robots;
  const auto has_own = [](const RobotSpec& robot) { return robot.body.tree.present(); };
  if (std::ranges::none_of(robots, has_own)) return;
  for (const double t : index.pose_t) {
    const SimTime time = match.rewinder().to(SimTime::from_s(t));
    for (size_t i = 0; i < robots.size(); ++i) {
      if (!has_own(robots[i])) continue;
      const JointAngles angles_rad = match.world().robot(i, time).joints_rad;
      for (size_t joint = 0; joint < robots[i].body.joint_count(); ++joint) {
        Series& series = index.robots[i].series[robots[i].body.joint_name(joint) + "_rad"];
        series.t.push_back(t);
        series.values.push_back(angles_rad[joint]);
      }
      const Pose X_WC =
          match.world().camera_link_pose(i, time) * match.renderer().mount(static_cast<int>(i));
      const Vec3 ahead = X_WC.R[2];
      index.robots[i].cameras.push_back(
          {static_cast<float>(X_WC.p.x), static_cast<float>(X_WC.p.y),
           static_cast<float>(maths::atan2(ahead.y, ahead.x)),
           static_cast<float>(maths::atan2(ahead.z, maths::length(ahead.x, ahead.y)))});
    }
  }
}

}  // namespace seam::tools
