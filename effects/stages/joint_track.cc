#include "effects/stages/joint_track.h"

#include <algorithm>

namespace seam::effects {

JointRole joint_role(const std::string& name) {
  if (name == "tilt") return JointRole::tilt;
  if (name == "pan") return JointRole::pan;
  if (name == "roll") return JointRole::roll;
  return JointRole::other;
}

void apply_encoder_effects(const Model& model, JointTrack& track) {
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->encoder) effect.definition->encoder(effect.values(), track);
  }
}

void apply_play(double width_rad, std::vector<double>& q_rad) {
  if (width_rad == 0 || q_rad.empty()) return;
  const double half = 0.5 * width_rad;
  double load = q_rad.front();
  for (double& q : q_rad) {
    load = std::clamp(load, q - half, q + half);
    q = load;
  }
}

}  // namespace seam::effects
