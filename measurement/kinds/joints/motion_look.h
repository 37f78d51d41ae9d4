// A coarse look for the parameters of an equation of motion: which values agree best with the
// accelerations that the logs show. Whole runs have many valleys, accelerations nearly none, so
// that this finds the valley in which a fit of whole runs begins.
#pragma once

#include <vector>

#include "effects/stages/torque/torque.h"
#include "measurement/kinds/joints/joints.h"

namespace seam::measurement {

// A row of a log with what is seen of the motion there: a parabola through `reach` rows on either
// side.
struct SeenMotion {
  size_t row, reach;
  double q_rad, w_radps, a_radps2;
  double reach_s;     // The reach as time, on the mean of both sides.
  double rest_radps;  // Slower counts as at rest.
};

// At each `stride`-th row of a log. The reach is as short as the noise allows.
std::vector<SeenMotion> seen_motion(const JointLog& log, size_t stride, double noise_rad);

class MotionLook {
 public:
  // Of the logs whose flag is set. A joint at rest shows that friction holds it, and nothing to
  // models `without_friction`: what most rows of a joint that sticks would tell these is that no
  // motor drives it and no load hangs on it.
  MotionLook(const JointLogs& set, const std::vector<char>& chosen, double noise_rad,
             bool without_friction);

  // What the model misses, comparable between models: in the unit of the data.
  double cost(const Model& model) const;
  // Descends from `model` in these parameters. Returns the cost; infinite where nothing moves.
  double descend(Model& model, const std::vector<Unknown>& unknowns) const;
  // Waves of torque over the angle, so many a turn of the joint, that would take most of what the
  // model misses of a joint that moves: the strongest first, no two of one peak.
  std::vector<double> torque_waves(const Model& model, double least, double most, double step,
                                   size_t count) const;

 private:
  // A part of the time over which an acceleration is seen: where the joint was in its middle.
  struct Piece {
    double at_s, weight;
    effects::MotorState state;
    double cos_q, sin_q;
    size_t row;  // Whose supply acts, and whose command without a latency.
  };
  struct Instant {
    const JointLog* log;
    double a_radps2, rest_radps, reach_s;
    bool moves;
    std::vector<Piece> pieces;
    double weights = 0;  // Sum.
  };

  static Instant instant_of(const JointLog& log, const SeenMotion& at);
  std::vector<double> misses(const Model& model) const;

  std::vector<Instant> instants_;
};

}  // namespace seam::measurement
