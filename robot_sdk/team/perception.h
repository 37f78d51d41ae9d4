// From a client's observations to percepts: the colour image of each frame with the head's angles
// at the moment each row was exposed, odometry steps, and team messages.
#pragma once

#include <deque>
#include <string>

#include "robot_sdk/robot.h"
#include "robot_sdk/team/world_model.h"

namespace seam::sdk {

struct PerceptionOptions {
  CameraBelief camera;  // Of the full image.
  NeckBelief neck;
  // True: the head's angles are taken at the middle of each row's exposure. False: one angle for
  // the whole frame, at its stamp, as a program without knowledge of the rolling shutter does.
  bool row_times = true;
  // True: what cannot be a beacon by its height, or the ball by its shape and size, is left out
  // (see has_plausible_height, could_be_ball), and the ball's radius allows for its lost rim.
  // False: every region is believed, as in the founding paper's experiments.
  bool check = false;
};

class Perception {
 public:
  explicit Perception(const PerceptionOptions& options = {}) : options_(options) {}

  // Call it once for each observation, in order.
  Percepts look(const Observation& seen);
  // The head's angles at a time, from the encoder log (straight between readings).
  HeadAngles head_at(int64_t time_ns) const;
  // When a row of a frame's colour image was exposed, in the middle of its window.
  int64_t row_time_ns(const Frame& frame, float row) const;

 private:
  void look_at_frame(const Frame& frame, Percepts& percepts) const;

  PerceptionOptions options_;
  std::deque<JointAngles> joints_;  // The last second.
  Odometry last_odometry_;
  bool has_odometry_ = false;
};

// One line of text for the radio, and back; a message that does not parse has player -1.
std::string encode(const TeamMessage& message);
TeamMessage decode_team_message(const std::string& payload);

}  // namespace seam::sdk
