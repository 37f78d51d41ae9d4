#include "effects/stages/torque/elastic.h"

#include "sim_core/base/maths.h"

namespace seam::effects {

SwingingLoad::SwingingLoad(const ElasticJoint& joint, double dt_s) : dt_s_(dt_s) {
  const double omega = 2 * maths::kPi * joint.frequency_hz;
  const double swings = omega * std::sqrt(1 - joint.damping * joint.damping);
  fades_ = joint.damping * omega, omega2_ = omega * omega;
  cosine_ = maths::cos(swings * dt_s), sine_ = maths::sin(swings * dt_s) / swings;
  left_ = maths::exp(-fades_ * dt_s);
}

void SwingingLoad::follow(double from_rad, double to_rad, ElasticState& state) const {
  if (!(dt_s_ > 0)) return;
  const double rate = (to_rad - from_rad) / dt_s_;
  // The load ahead of the drive is a free swing.
  const double ahead = state.q_rad - from_rad, gains = state.w_radps - rate;
  state.q_rad = to_rad + left_ * (ahead * (cosine_ + fades_ * sine_) + gains * sine_);
  state.w_radps = rate + left_ * (gains * (cosine_ - fades_ * sine_) - ahead * omega2_ * sine_);
}

void follow_jump(const ElasticJoint& joint, double by_rad, ElasticState& state) {
  state.w_radps += 4 * maths::kPi * joint.frequency_hz * joint.damping * by_rad;
}

}  // namespace seam::effects
