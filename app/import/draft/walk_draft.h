// Trajectories as sets: the poses of a camera, or a robot's walk with its odometry.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "app/exchange/exchange.h"
#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"
#include "sim_core/base/pose.h"

namespace seam::app {

struct StampedPose {
  int64_t ns = 0;
  Vec3 p{0.0};
  std::array<double, 4> q{1, 0, 0, 0};  // w, x, y, z; of length 1.
};

struct PlanarPose {
  int64_t ns = 0;
  double x_m = 0, y_m = 0, theta_rad = 0;
};

struct VelocityCommand {
  int64_t ns = 0;
  double vx_mps = 0, vy_mps = 0, omega_radps = 0;
};

Mat3 rotation_of(const std::array<double, 4>& q);
// The unit quaternion (w, x, y, z) of a rotation.
std::array<double, 4> quaternion_of(const Mat3& R);
// On the plane z = 0, the heading that of the body's x axis.
PlanarPose planar(const StampedPose& pose);
// The same of a whole path; throws where it leaves the plane, and says what the plane leaves out.
std::vector<PlanarPose> planar(const std::vector<StampedPose>& path, const std::string& where,
                               SetDraft& draft);

// Throws where a path leaves the plane z = const: heights that vary beside its extent, a body
// whose z axis (`up`; empty: not known) tilts. `remedy` says what to do. Returns what is left out
// on the plane, in words; empty: nothing.
std::string check_plane(const std::vector<Vec3>& places, const std::vector<Vec3>& up,
                        const std::string& where, const std::string& remedy);

// Throws where the usual speed is no robot's and the user named no unit of length.
void check_speed(const std::vector<StampedPose>& poses, const std::string& where,
                 const ImportRequest& request);

// A protocol of points before a camera that goes along the poses. `stamps`: when frames were taken;
// empty: evenly.
void draft_poses(const std::vector<StampedPose>& poses, const std::vector<int64_t>& stamps,
                 const Pose& X_BC, const PlainCamera& camera, SetDraft& draft);

// A camera where the files have none, of the size that was asked for; the draft says so.
PlainCamera camera_for_granted(const ImportRequest& request, SetDraft& draft);

// Walks as `odometry`: what was commanded, and the poses measured, by the commands' times. Poses
// within the walk alone count; both must be in order of time. A run begins at each of `breaks`, or
// where there are none, a long walk is cut into parts.
void draft_walk(const std::vector<VelocityCommand>& commands, const std::vector<PlanarPose>& poses,
                SetDraft& draft, const std::vector<int64_t>& breaks = {});

// The estimate's own steps stand for commands: what odometry would have said. Names are of files.
void draft_walk_of_estimate(const std::vector<StampedPose>& truth, const std::string& truth_name,
                            const std::vector<StampedPose>& estimate,
                            const std::string& estimate_name, SetDraft& draft);
// From successive planar poses, the velocities of the body between them.
std::vector<VelocityCommand> velocities_of(const std::vector<PlanarPose>& poses);

}  // namespace seam::app
