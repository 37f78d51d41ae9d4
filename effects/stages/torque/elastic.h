// A joint whose load hangs on the drive by a spring and a damper:
//
//   d2q/dt2 = w^2 (m - q) + 2 damping w (dm/dt - dq/dt),   w = 2 pi / period
//
// with m where the drive (behind its play) is. What the load does to the drive is left out: gears
// make the drive's inertia, seen from the load, the larger one, or the controller holds it.
#pragma once

namespace seam::effects {

struct ElasticJoint {
  double period_s = 0;  // 0: stiff.
  double damping = 0;   // Share of the critical one, below 1.

  bool present() const { return period_s > 0; }
};

struct ElasticState {
  double q_rad = 0;
  double w_radps = 0;
};

// Where the drive is, and how fast.
struct DriveState {
  double q_rad = 0;
  double w_radps = 0;
};

// Moves the load over a step of time while the drive goes from one state to another along a cubic:
// a closed form.
class SwingingLoad {
 public:
  SwingingLoad(const ElasticJoint& joint, double dt_s);
  void follow(const DriveState& from, const DriveState& to, ElasticState& state) const;
  // The drive goes evenly.
  void follow(double from_rad, double to_rad, ElasticState& state) const;

 private:
  double dt_s_, fades_, omega2_, lags_s3_;
  double cosine_, sine_, left_;  // Of the free swing over the step; the sine over its frequency.
};

// The drive jumps by this much, which its damper passes on at once.
void follow_jump(const ElasticJoint& joint, double by_rad, ElasticState& state);

}  // namespace seam::effects
