#include "sim_core/body/actuator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_core/base/error.h"

namespace seam {
namespace {

// From `start` on: from `from_rad` towards `to_rad` at `speed_radps`, then rest.
struct Motion {
  SimTime start;
  double from_rad = 0;
  double to_rad = 0;
  double speed_radps = 0;

  double at(SimTime time) const {
    const double way = to_rad - from_rad;
    const double most = speed_radps * (time - start).s();
    if (std::abs(way) <= most) return to_rad;
    return from_rad + std::copysign(most, way);
  }
  void visit(StateVisitor& visitor) {
    visitor.field("start", start);
    visitor.field("from_rad", from_rad);
    visitor.field("to_rad", to_rad);
    visitor.field("speed_radps", speed_radps);
  }
};

class LimitedActuator final : public JointActuator {
 public:
  explicit LimitedActuator(double initial_rad) {
    motions_.push_back(
        {SimTime::from_ns(std::numeric_limits<int64_t>::min() / 4), initial_rad, initial_rad, 0});
  }
  void command(SimTime time, double target_rad, double max_speed_radps) override {
    while (motions_.size() > 1 && motions_.back().start >= time) motions_.pop_back();
    const double here = motions_.back().at(time);
    motions_.push_back({time, here, target_rad, max_speed_radps});
  }
  double angle(SimTime time) const override {
    size_t i = motions_.size() - 1;
    while (i > 0 && motions_[i].start > time) --i;
    return motions_[i].at(time);
  }
  void forget_before(SimTime time) override {
    size_t keep = 0;
    while (keep + 1 < motions_.size() && motions_[keep + 1].start <= time) ++keep;
    motions_.erase(motions_.begin(), motions_.begin() + static_cast<std::ptrdiff_t>(keep));
  }
  void visit(StateVisitor& visitor) override {
    visitor.list("motions", motions_);
    if (motions_.empty()) throw InputError("snapshot: a joint without motion");
  }

 private:
  std::vector<Motion> motions_;  // Never empty, ascending.
};

}  // namespace

std::unique_ptr<JointActuator> limited_actuator(double initial_rad) {
  return std::make_unique<LimitedActuator>(initial_rad);
}

}  // namespace seam
