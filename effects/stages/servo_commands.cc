// The queue of a servo's commands, ascending in the time at which they act.
#include <limits>

#include "effects/stages/servo.h"

namespace seam::effects {

void Servo::command(double t_s, double command_rad, bool enabled, double kp) {
  if (next_ > 64) {
    queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ = 0;
  }
  queue_.push_back({t_s + model_.latency_s, command_rad, enabled, kp});
}

double Servo::last_acting(double until_s) const {
  constexpr double kSameTime_s = 1e-9;
  double last_s = std::numeric_limits<double>::quiet_NaN();
  for (size_t i = next_; i < queue_.size() && queue_[i].acts_s < until_s - kSameTime_s; ++i)
    last_s = queue_[i].acts_s;
  return last_s;
}

void Servo::shift_commands(double until_s, double by_s) {
  for (size_t i = next_; i < queue_.size() && queue_[i].acts_s <= until_s; ++i)
    queue_[i].acts_s += by_s;
}

}  // namespace seam::effects
