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

// What team mates send each other, several times a second.
struct TeamMessage {
  int player = 0;  // 0..3 within the team.
  FieldPose pose;
  bool sees_ball = false;
  float ball_x_m = 0, ball_y_m = 0;  // On the field.
  float ball_distance_m = 0;         // From that player.
};

// What the referee says to this robot, as far as it says something about the world.
struct Situation {
  enum Phase { waiting, ready, set, playing };
  Phase phase = waiting;
  bool penalised = false;
  bool own_kick_off = false;
};

// One round of perception.
struct Percepts {
  float time_s = 0;
  FieldPose odometry_step;  // Motion since the last round, in the body frame.
  std::vector<LandmarkSighting> landmarks;
  std::optional<BallSighting> ball;
  bool has_frame = false;  // A frame was looked at in this round.
  std::vector<TeamMessage> messages;
  Situation situation;
};

struct BallBelief {
  float x_m = 0, y_m = 0;  // In the body frame.
  float seen_s = -1e6f;    // When it was last seen.
  bool reported = false;   // By a team mate or the rules rather than by the own camera.
  bool held = false;       // Between the own legs, where the camera does not see it.

  float distance_m() const;
  float bearing_rad() const;
};

class WorldModel {
 public:
  WorldModel(int player, bool attacks_skyblue, uint64_t seed);

  void update(const Percepts& percepts);
  // The ball is held between the front legs, and seen by nobody.
  void hold_ball(bool held) { holds_ball_ = held; }

  const PoseEstimate& pose() const { return pose_; }
  const BallBelief& ball() const { return ball_; }
  const Situation& situation() const { return situation_; }
  // The ball still lies where the referee put it, and is the other team's to play.
  bool is_opponents_kick_off() const;
  // Where the robot stood at the first kick-off: there the referee puts those that stand wrong at
  // the next.
  const std::optional<FieldPose>& home() const { return home_; }
  // Age of the ball belief, seconds.
  float ball_age_s() const { return time_s_ - ball_.seen_s; }
  float time_s() const { return time_s_; }
  int player() const { return player_; }

  // Bearing in the body frame, and distance, of a place on the field.
  float bearing_to(float x_m, float y_m) const;
  float distance_to(float x_m, float y_m) const;
  // The same to the opponents' goal: where it is free, as just seen, or else to its middle by the
  // pose.
  float goal_bearing() const;
  float goal_distance() const;
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

  void take_situation(const Situation& situation);
  void take_ball(const Percepts& percepts);
  void take_mates_ball();
  bool could_be_there(const BallSighting& ball) const;
  bool stands_wrong() const;
  void field_to_body(float x_m, float y_m, float& ahead_m, float& left_m) const;

  int player_;
  bool attacks_skyblue_;
  ParticleFilter filter_;
  PoseEstimate pose_;
  BallBelief ball_;
  std::array<Mate, kTeamSize> mates_;
  Situation situation_;
  std::optional<FieldPose> home_;
  float played_since_s_ = 0;
  bool holds_ball_ = false;
  float seen_goal_rad_ = 0,
        seen_goal_s_ = -1e6f;  // The opponents' goal, turned with the body since.
  std::optional<BallBelief>
      doubted_;  // A ball far from where it was a moment ago: one more sighting decides.
  float time_s_ = 0;
};

}  // namespace seam::sdk
