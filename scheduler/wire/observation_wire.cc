// What a robot gets, as a message.
#include "scheduler/wire/wire.h"
#include "seam/v1/simulation.pb.h"

namespace seam::scheduler {

namespace {

void joints_to(const RobotSensors& sensors, const JointReading& reading, v1::JointAngles& wire) {
  const JointAngles& joints_rad = reading.rad;
  wire.set_time_ns(reading.time.ns());
  if (sensors.tree_joints) {
    wire.mutable_angles_rad()->Add(joints_rad.begin(), joints_rad.begin() + *sensors.tree_joints);
    return;
  }
  wire.set_tilt_rad(joints_rad[kTilt]);
  wire.set_pan_rad(joints_rad[kPan]);
  wire.set_roll_rad(joints_rad[kRoll]);
  wire.mutable_legs_rad()->Add(joints_rad.begin() + kHeadJoints, joints_rad.begin() + kJoints);
}

void vector_to(const Vec3& vector, v1::Vector3& wire) {
  wire.set_x(vector.x);
  wire.set_y(vector.y);
  wire.set_z(vector.z);
}

void sensors_to(const Observation& observation, v1::Sensors& wire) {
  const RobotSensors& reading = observation.sensors;
  joints_to(reading, reading.joints, *wire.mutable_joints());
  for (const JointReading& joints : reading.joint_log)
    joints_to(reading, joints, *wire.add_joint_log());
  vector_to(reading.acceleration_m_s2, *wire.mutable_acceleration_m_s2());
  if (reading.angular_velocity_rad_s)
    vector_to(*reading.angular_velocity_rad_s, *wire.mutable_angular_velocity_rad_s());
  v1::Pose2& odometry = *wire.mutable_odometry();
  odometry.set_x_m(reading.odometry.x_m);
  odometry.set_y_m(reading.odometry.y_m);
  odometry.set_heading_rad(reading.odometry.theta_rad);
  for (const bool contact : reading.paw_contact) wire.add_paw_contact(contact);
}

void frame_to(const Frame& frame, v1::Frame& wire) {
  wire.set_index(frame.frame_index);
  wire.set_stamp_ns(frame.stamp.ns());
  wire.set_width_px(static_cast<uint32_t>(frame.width_px));
  wire.set_height_px(static_cast<uint32_t>(frame.height_px));
  wire.set_rgb(frame.rgb.data(), frame.rgb.size());
  wire.set_ycrcb(frame.ycrcb.data(), frame.ycrcb.size());
  wire.set_colours(frame.colours.data(), frame.colours.size());
  wire.set_colours_width_px(static_cast<uint32_t>(frame.colours_width_px));
  wire.set_colours_height_px(static_cast<uint32_t>(frame.colours_height_px));
  for (const RowWindow& row : frame.rows) {
    wire.add_row_start_ns(row.start.ns());
    wire.add_row_end_ns(row.end.ns());
  }
  wire.set_fingerprint(frame.fingerprint);
}

}  // namespace

void observation_to_wire(const Observation& observation, v1::Observation& wire) {
  wire.set_sequence(observation.sequence);
  wire.set_time_ns(observation.time.ns());
  sensors_to(observation, *wire.mutable_sensors());
  for (const auto& frame : observation.frames) frame_to(*frame, *wire.add_frames());
  for (const RadioMessage& message : observation.messages) {
    v1::RadioMessage& out = *wire.add_messages();
    out.set_from(message.from);
    out.set_sent_ns(message.sent.ns());
    out.set_arrived_ns(message.arrived.ns());
    out.set_payload(message.payload);
  }
  const GameState& game = observation.game;
  v1::GameState& out = *wire.mutable_game();
  out.set_state(static_cast<uint32_t>(game.state));
  out.set_first_half(game.first_half);
  out.set_kick_off_team(game.kick_off_team == Team::red ? "red" : "blue");
  out.set_own_score(game.own_score);
  out.set_opponent_score(game.opponent_score);
  out.set_remaining_ns(game.remaining.ns());
  out.set_penalty(static_cast<uint32_t>(game.penalty));
  out.set_penalty_remaining_ns(game.penalty_remaining.ns());
}

}  // namespace seam::scheduler
