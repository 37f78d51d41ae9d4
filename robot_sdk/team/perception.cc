#include "robot_sdk/team/perception.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace seam::sdk {
namespace {

constexpr int64_t kMemory_ns = 1'000'000'000;
constexpr float kRim_px = 0.4f;  // Of the ball's radius in the colour image.
constexpr double kTurn_rad = 6.283185307179586;

HeadAngles angles_of(const JointAngles& joints) {
  return {static_cast<float>(joints.tilt_rad), static_cast<float>(joints.pan_rad),
          static_cast<float>(joints.roll_rad)};
}

Situation situation_of(const Game& game) {
  Situation situation{.penalised = game.penalty != 0};
  if (game.state == Game::ready) situation.phase = Situation::ready;
  if (game.state == Game::set) situation.phase = Situation::set;
  if (game.state == Game::playing) situation.phase = Situation::playing;
  return situation;
}

}  // namespace

HeadAngles Perception::head_at(int64_t time_ns) const {
  if (joints_.empty()) return {};
  const auto after = std::lower_bound(
      joints_.begin(), joints_.end(), time_ns,
      [](const JointAngles& joints, int64_t time) { return joints.time_ns < time; });
  if (after == joints_.begin()) return angles_of(joints_.front());
  if (after == joints_.end()) return angles_of(joints_.back());
  const HeadAngles a = angles_of(*(after - 1)), b = angles_of(*after);
  const float t = static_cast<float>(time_ns - (after - 1)->time_ns) /
                  static_cast<float>(after->time_ns - (after - 1)->time_ns);
  return {a.tilt_rad + t * (b.tilt_rad - a.tilt_rad), a.pan_rad + t * (b.pan_rad - a.pan_rad),
          a.roll_rad + t * (b.roll_rad - a.roll_rad)};
}

int64_t Perception::row_time_ns(const Frame& frame, float row) const {
  const float rows_per_row =
      static_cast<float>(frame.height_px) / static_cast<float>(frame.colours_height_px);
  const int v = std::clamp(static_cast<int>((row + 0.5f) * rows_per_row), 0, frame.height_px - 1);
  return frame.row_middle_ns(v);
}

void Perception::look_at_frame(const Frame& frame, Percepts& percepts) const {
  if (frame.colours.empty()) return;
  const ColourMask mask{
      frame.colours_width_px,
      frame.colours_height_px,
      {reinterpret_cast<const uint8_t*>(frame.colours.data()), frame.colours.size()}};
  const HeadAtRow head = [&](float row) {
    return head_at(options_.row_times ? row_time_ns(frame, row) : frame.stamp_ns);
  };
  percepts.has_frame = true;
  percepts.ball = find_ball_in_frame(
      mask, frame.width_px, frame.height_px, head, options_.camera, options_.neck,
      {.rim_px = options_.check ? kRim_px : 0, .check = options_.check});
  const CameraBelief camera =
      options_.camera.of_colours(frame.width_px, frame.height_px, mask.width_px, mask.height_px);
  const int least_area_px = colour_factor(frame.width_px, mask.width_px) > 1 ? 4 : 12;
  for (const LandmarkSighting& sighting :
       find_landmarks(mask, head, camera, options_.neck, least_area_px)) {
    if (!options_.check || has_plausible_height(sighting)) percepts.landmarks.push_back(sighting);
  }
}

Percepts Perception::look(const Observation& seen) {
  for (const JointAngles& joints : seen.sensors.joint_log) {
    if (joints_.empty() || joints.time_ns > joints_.back().time_ns) joints_.push_back(joints);
  }
  if (joints_.empty() || seen.sensors.joints.time_ns > joints_.back().time_ns)
    joints_.push_back(seen.sensors.joints);
  while (joints_.front().time_ns < seen.time_ns - kMemory_ns && joints_.size() > 2)
    joints_.pop_front();

  Percepts percepts{.time_s = static_cast<float>(seen.time_s())};
  const Odometry& now = seen.sensors.odometry;
  if (has_odometry_) {
    const float c = std::cos(static_cast<float>(last_odometry_.heading_rad));
    const float s = std::sin(static_cast<float>(last_odometry_.heading_rad));
    const float dx = static_cast<float>(now.x_m - last_odometry_.x_m);
    const float dy = static_cast<float>(now.y_m - last_odometry_.y_m);
    const double turn = std::remainder(now.heading_rad - last_odometry_.heading_rad, kTurn_rad);
    percepts.odometry_step = {c * dx + s * dy, -s * dx + c * dy, static_cast<float>(turn)};
  }
  percepts.situation = situation_of(seen.game);
  last_odometry_ = now;
  has_odometry_ = true;

  for (const Frame& frame : seen.frames) look_at_frame(frame, percepts);
  for (const RadioMessage& message : seen.messages)
    percepts.messages.push_back(decode_team_message(message.payload));
  return percepts;
}

std::string encode(const TeamMessage& message) {
  char text[160];
  std::snprintf(text, sizeof text, "T %d %.3f %.3f %.3f %d %.3f %.3f %.3f", message.player,
                message.pose.x_m, message.pose.y_m, message.pose.theta_rad,
                message.sees_ball ? 1 : 0, message.ball_x_m, message.ball_y_m,
                message.ball_distance_m);
  return text;
}

TeamMessage decode_team_message(const std::string& payload) {
  TeamMessage message;
  int sees = 0;
  const int read = std::sscanf(payload.c_str(), "T %d %f %f %f %d %f %f %f", &message.player,
                               &message.pose.x_m, &message.pose.y_m, &message.pose.theta_rad, &sees,
                               &message.ball_x_m, &message.ball_y_m, &message.ball_distance_m);
  message.sees_ball = sees == 1;
  if (read != 8) message.player = -1;
  return message;
}

}  // namespace seam::sdk
