#include "robot_sdk/from_wire.h"

#include "seam/v1/simulation.pb.h"

namespace seam::sdk {

namespace {

JointAngles joints_from(const v1::JointAngles& wire) {
  JointAngles joints{wire.time_ns(),
                     wire.tilt_rad(),
                     wire.pan_rad(),
                     wire.roll_rad(),
                     {wire.legs_rad().begin(), wire.legs_rad().end()},
                     {wire.angles_rad().begin(), wire.angles_rad().end()}};
  if (!joints.legs_rad.empty()) {
    joints.angles_rad = {joints.tilt_rad, joints.pan_rad, joints.roll_rad};
    joints.angles_rad.insert(joints.angles_rad.end(), joints.legs_rad.begin(),
                             joints.legs_rad.end());
  }
  return joints;
}

Vector3d vector_from(const v1::Vector3& wire) {
  return {wire.x(), wire.y(), wire.z()};
}

Frame frame_from(const v1::Frame& wire) {
  Frame frame{wire.index(),
              wire.stamp_ns(),
              static_cast<int>(wire.width_px()),
              static_cast<int>(wire.height_px()),
              wire.rgb(),
              wire.ycrcb(),
              wire.colours(),
              static_cast<int>(wire.colours_width_px()),
              static_cast<int>(wire.colours_height_px())};
  frame.row_start_ns.assign(wire.row_start_ns().begin(), wire.row_start_ns().end());
  frame.row_end_ns.assign(wire.row_end_ns().begin(), wire.row_end_ns().end());
  return frame;
}

}  // namespace

Observation from_wire(const v1::Observation& wire) {
  Observation observation;
  observation.sequence = wire.sequence();
  observation.time_ns = wire.time_ns();
  Sensors& sensors = observation.sensors;
  const v1::Sensors& from = wire.sensors();
  sensors.joints = joints_from(from.joints());
  for (const v1::JointAngles& joints : from.joint_log())
    sensors.joint_log.push_back(joints_from(joints));
  sensors.acceleration_m_s2 = vector_from(from.acceleration_m_s2());
  if (from.has_angular_velocity_rad_s())
    sensors.angular_velocity_rad_s = vector_from(from.angular_velocity_rad_s());
  sensors.odometry = {from.odometry().x_m(), from.odometry().y_m(), from.odometry().heading_rad()};
  for (int i = 0; i < from.paw_contact_size() && i < 4; ++i)
    sensors.paw_contact[i] = from.paw_contact(i);
  for (const v1::Frame& frame : wire.frames()) observation.frames.push_back(frame_from(frame));
  for (const v1::RadioMessage& message : wire.messages())
    observation.messages.push_back(
        {message.from(), message.sent_ns(), message.arrived_ns(), message.payload()});
  const v1::GameState& game = wire.game();
  observation.game = {static_cast<Game::State>(game.state()),
                      game.first_half(),
                      game.kick_off_team(),
                      game.own_score(),
                      game.opponent_score(),
                      game.remaining_ns(),
                      static_cast<int>(game.penalty()),
                      game.penalty_remaining_ns()};
  return observation;
}

}  // namespace seam::sdk
