// One robot in the world: joints, gait and walking; its body's place is kept by the world.
#pragma once

#include <memory>
#include <vector>

#include "sim_core/body/kinematics.h"
#include "sim_core/world/sensors.h"
#include "sim_core/world/world.h"

namespace seam {

// Where a body stands at the ends of the current interval's physics steps.
struct PlanarTrack {
  std::vector<Pose2> points;  // substeps + 1, evenly spaced in time; theta is not wrapped.

  // `fraction` in [0, 1] of the interval; straight between points: the integrator's own order.
  Pose2 at(double fraction) const;
  void visit(StateVisitor& visitor);
};

// Height, pitch and roll of a body that stands on its paws: the plane through the lowest paws.
struct Attitude {
  double height_m = 0;
  double pitch_rad = 0;  // Positive: nose down.
  double roll_rad = 0;   // Positive: left side up.

  void visit(StateVisitor& visitor);
};
Attitude attitude_on_paws(const RobotBody& body, const std::array<Vec3, kLegs>& paws_B);
// Leg angles of the trot at this phase (0 to 1), with strides for this walk.
void gait_angles(const RobotBody& body, double phase, const BodyVelocity& stride,
                 JointAngles& joints);

// Where a body with constant body-frame velocity is after this time: an arc, exactly.
Pose2 moved(const Pose2& from, const BodyVelocity& velocity, double duration_s);

class Robot {
 public:
  Robot(const RobotSpec& spec, const RobotPartsFactory& parts, RandomStream stream,
        size_t substeps);

  const RobotSpec& spec() const { return *spec_; }
  // The head follows at once; legs from the interval's end on, so that a step fixes the body's
  // attitude for its whole interval.
  void apply(const RobotCommand& command, SimTime time, SimTime interval_end);
  void freeze(SimTime time);
  // The joints of this kick follow its motion until it is over, whatever else is commanded.
  void begin_kick(const KickSpec& kick, SimTime time, SimTime interval_end);
  // Drops history before `start` and gives the joints what is due in [start, end).
  void begin_interval(SimTime start, SimTime end);
  // The body's velocity over physics step `k` of the interval; stands where it may not walk.
  BodyVelocity drive(size_t k, SimTime start, SimDuration step, bool may_walk);
  // After the interval's physics: the body's origin at its end.
  void end_interval();

  JointAngles joint_angles(SimTime time) const;
  // As far as the camera's place depends on them.
  JointAngles camera_joint_angles(SimTime time) const;
  // No part is ever farther from the robot's place, m.
  double reach_m() const { return reach_m_; }
  double joint_angle(int joint, SimTime time) const {
    return joints_[static_cast<size_t>(joint)]->angle(time);
  }
  double encoder(int joint, SimTime time) const {
    return joints_[static_cast<size_t>(joint)]->encoder(time);
  }
  // The body on its paws over its place on the ground, at this fraction of the interval: height,
  // pitch and sway follow from the legs at the interval's ends, straight between.
  Pose body_pose(const Pose2& place, double fraction) const;
  // All that a picture shows of it then.
  Posture posture(const Pose2& place, double fraction, SimTime time) const;

  void place(const Pose2& pose);
  // Where the paws are in the body's frame.
  std::array<Vec3, kLegs> paws(SimTime time) const;
  // What the sensors would measure, at `fraction` of the interval.
  SensorTruth sense(SimTime time, double fraction, SimDuration interval) const;
  void visit(StateVisitor& visitor);

  PlanarTrack track;  // Where the body truly is.

 private:
  struct Pending {
    SimTime time;
    int64_t joint = 0;
    double angle_rad = 0;
    double speed_radps = 0;
    void visit(StateVisitor& visitor);
  };
  void command_joint(SimTime time, int joint, double angle_rad, double speed_radps);
  void give_due(SimTime end);
  void plan(Pending next, SimTime interval_end);
  bool kicks_with(int joint, SimTime time) const {
    return time < kick_end_ && (kick_joints_ >> joint & 1) != 0;
  }
  Attitude attitude(SimTime time) const;
  Posture body_posture(const Pose2& place, double fraction) const;  // Without joints.
  void command_gait(SimTime start, SimTime end);
  double top_speed(int joint) const;

  const RobotSpec* spec_;
  double reach_m_;
  std::vector<std::unique_ptr<JointActuator>> joints_;
  std::unique_ptr<LocomotionModel> locomotion_;
  std::vector<Pending> pending_;      // Ascending in time.
  PlanarTrack dead_reckoning_;        // Where the legs were commanded to go.
  std::array<Attitude, 2> attitude_;  // At the interval's start and end.
  std::array<Vec3, 3> origin_{};  // The body's origin one interval ago, at the start, at the end.
  BodyVelocity walk_;
  int64_t kick_joints_ = 0;  // Bit j: joint j follows a kick until kick_end_.
  SimTime kick_end_;
  double gait_phase_ = 0;  // Strides, from 0 to 1.
  BodyVelocity
      stride_;  // The walk that the legs show: follows walk_ with the gait's time constant.
  bool legs_commanded_ = false;  // Joint-level commands hold the legs until the next walk command.
};

}  // namespace seam
