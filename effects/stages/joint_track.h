// Stage `joint`, from an encoder's log to the true angle of the joint.
#pragma once

#include <string>
#include <vector>

#include "effects/model.h"
#include "effects/row_columns.h"
#include "sim_core/base/random.h"

namespace seam::effects {

// Which parameter of an encoder effect applies: tilt_rad, pan_rad or roll_rad. The single joint of
// a servo log counts as pan, whatever its name.
enum class JointRole { tilt, pan, roll, other };
JointRole joint_role(const std::string& name);

struct JointSeries {
  std::string name;
  JointRole role = JointRole::other;
  std::vector<double> q_rad;  // Logged; encoder hooks turn it into the true angle.
};

// The log of all joints of one run, on common times. Encoder hooks act in the order of
// composition: eccentricity, scale and offset, backlash.
struct JointTrack {
  std::vector<double> time_s;
  std::vector<JointSeries> joints;
  double quantisation_step_rad = 0;  // Adds a spread of step / sqrt(12) to the angle.
};

// The stream of what an encoder rounds away, one uniform number a joint and sample.
inline RandomStream rounding_stream(RandomStream measurement) {
  return measurement.child("encoder_quantisation");
}

// Applies every encoder hook of the model, in place.
void apply_encoder_effects(const Model& model, JointTrack& track);

// What a `joint_map` (an expression effect of stage joint) sees.
struct JointSample {
  double q_rad = 0;
  double rate_rad_per_s = 0;
  double command_rad = 0;
  double t_s = 0;
  JointRole role = JointRole::pan;
  RowColumns columns;
};

// The play operator (Krasnosel'skii): the load behind a gap of this width, starting centred.
void apply_play(double width_rad, std::vector<double>& q_rad);

}  // namespace seam::effects
