#include "effects/stages/torque/elastic.h"

#include <cmath>

#include "sim_core/base/maths.h"

namespace seam::effects {

SwingingLoad::SwingingLoad(const ElasticJoint& joint, double dt_s) : dt_s_(dt_s) {
  const double omega = 2 * maths::kPi / joint.period_s;
  const double swings = omega * std::sqrt(1 - joint.damping * joint.damping);
  fades_ = joint.damping * omega, omega2_ = omega * omega;
  lags_s3_ = 2 * joint.damping / (omega2_ * omega);
  cosine_ = maths::cos(swings * dt_s), sine_ = maths::sin(swings * dt_s) / swings;
  left_ = maths::exp(-fades_ * dt_s);
}

// The load ahead of the drive is a free swing beside what the drive's acceleration, here linear in
// time, holds it back by.
void SwingingLoad::follow(const DriveState& from, const DriveState& to, ElasticState& state) const {
  if (!(dt_s_ > 0)) return;
  const double mean_radps = (to.q_rad - from.q_rad) / dt_s_;
  const double first = (6 * mean_radps - 4 * from.w_radps - 2 * to.w_radps) / dt_s_;
  const double last = (4 * to.w_radps + 2 * from.w_radps - 6 * mean_radps) / dt_s_;
  const double jerk = (last - first) / dt_s_;
  const double drifts = -jerk / omega2_;
  const double ahead = state.q_rad - from.q_rad + first / omega2_ - lags_s3_ * jerk;
  const double gains = state.w_radps - from.w_radps - drifts;
  state.q_rad = to.q_rad - last / omega2_ + lags_s3_ * jerk +
                left_ * (ahead * (cosine_ + fades_ * sine_) + gains * sine_);
  state.w_radps =
      to.w_radps + drifts + left_ * (gains * (cosine_ - fades_ * sine_) - ahead * omega2_ * sine_);
}

void SwingingLoad::follow(double from_rad, double to_rad, ElasticState& state) const {
  if (!(dt_s_ > 0)) return;
  const double radps = (to_rad - from_rad) / dt_s_;
  follow({from_rad, radps}, {to_rad, radps}, state);
}

void follow_jump(const ElasticJoint& joint, double by_rad, ElasticState& state) {
  state.w_radps += 4 * maths::kPi / joint.period_s * joint.damping * by_rad;
}

}  // namespace seam::effects
