// What a player believes: its own pose, where the ball is, where its team mates are. Fed by its own
// camera and odometry and by the radio alone.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "robot_sdk/localization/particle_filter.h"
#include "robot_sdk/vision/ball_detector.h"

namespace seam::sdk {

inline constexpr int kTeamSize = 4;

// What team mates tell each other, several times a second.
struct TeamMessage {
  int player = 0;  // 0..3 within the team.
  FieldPose pose;
  bool sees_ball = false;
  float ball_x_m = 0, ball_y_m = 0;  // On the field.
  float ball_distance_m = 0;         // From that player.
};

// One round of perception.
struct Percepts {
  float time_s = 0;
  FieldPose odometry_step;  // Motion since the last round, in the body frame.
  std::vector<LandmarkSighting> landmarks;
  std::optional<BallSighting> ball;
  bool has_frame = false;  // A frame was looked at in this round.
  std::vector<TeamMessage> messages;
};

struct BallBelief {
  float x_m = 0, y_m = 0;  // In the body frame.
  float seen_s = -1e6f;    // When it was last seen.
  bool told = false;       // By a team mate rather than by the own camera.

  float distance_m() const;
  float bearing_rad() const;
};

class WorldModel {
 public:
  WorldModel(int player, bool attacks_skyblue, uint64_t seed);

  void update(const Percepts& percepts);

  const PoseEstimate& pose() const { return pose_; }
  const BallBelief& ball() const { return ball_; }
  // Age of the ball belief, seconds.
  float ball_age_s() const { return time_s_ - ball_.seen_s; }
  float time_s() const { return time_s_; }
  int player() const { return player_; }

  // Bearing in the body frame, and distance, of a place on the field.
  float bearing_to(float x_m, float y_m) const;
  float distance_to(float x_m, float y_m) const;
  // +1 where the opponents' goal is at +x, -1 where it is at -x.
  float attack_sign() const { return attacks_skyblue_ ? 1.0f : -1.0f; }
  // True where no team mate that sees the ball is nearer to it.
  bool is_nearest_to_ball() const;
  TeamMessage message() const;

 private:
  struct Mate {
    TeamMessage message;
    float heard_s = -1e6f;
  };

  void take_ball(const Percepts& percepts);
  void field_to_body(float x_m, float y_m, float& ahead_m, float& left_m) const;

  int player_;
  bool attacks_skyblue_;
  ParticleFilter filter_;
  PoseEstimate pose_;
  BallBelief ball_;
  std::array<Mate, kTeamSize> mates_;
  float time_s_ = 0;
};

}  // namespace seam::sdk
