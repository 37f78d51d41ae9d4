#include "app/logs/estimate_errors.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam::app {

namespace {

using scheduler::LogCursor;
using scheduler::Topic;

constexpr size_t kPoseSize = std::size(scheduler::kPoseFields);

// The poses of all robots and the ball over time.
class Truth {
 public:
  explicit Truth(const scheduler::Log& log) : robots_(log.header().robots.size()) {
    LogCursor cursor(log, {Topic::step});
    while (const auto record = cursor.next()) {
      const auto& step = std::get<scheduler::StepRecord>(*record);
      if (step.poses.size() != kPoseSize * robots_ + 3) continue;
      times_.push_back(step.time);
      poses_.push_back(step.poses);
    }
    if (times_.empty()) throw InputError(log.name() + ": the log holds no poses to compare with");
  }

  Pose2 robot(int robot, SimTime time) const {
    const size_t at = kPoseSize * static_cast<size_t>(robot);
    const auto [before, after, part] = around(time);
    const double turn = maths::wrap_angle(after[at + 2] - static_cast<double>(before[at + 2]));
    return {mix(before[at], after[at], part), mix(before[at + 1], after[at + 1], part),
            maths::wrap_angle(before[at + 2] + part * turn)};
  }
  Pose2 ball(SimTime time) const {
    const size_t at = kPoseSize * robots_;
    const auto [before, after, part] = around(time);
    return {mix(before[at], after[at], part), mix(before[at + 1], after[at + 1], part), 0};
  }

 private:
  struct Around {
    const std::vector<float>& before;
    const std::vector<float>& after;
    double part;  // From `before` to `after`.
  };
  static double mix(double a, double b, double part) { return a + part * (b - a); }

  Around around(SimTime time) const {
    const auto found = std::lower_bound(times_.begin(), times_.end(), time);
    if (found == times_.begin()) return {poses_.front(), poses_.front(), 0};
    if (found == times_.end()) return {poses_.back(), poses_.back(), 0};
    const auto i = static_cast<size_t>(found - times_.begin());
    return {poses_[i - 1], poses_[i], (time - times_[i - 1]).s() / (times_[i] - times_[i - 1]).s()};
  }

  size_t robots_;
  std::vector<SimTime> times_;
  std::vector<std::vector<float>> poses_;
};

std::optional<double> value_of(const scheduler::Decision& decision, const char* name) {
  for (const scheduler::DebugItem& item : decision.debug)
    if (item.kind == scheduler::DebugItem::Kind::value && item.name == name &&
        std::isfinite(item.value))
      return item.value;
  return std::nullopt;
}

void compare(const Truth& truth, SimTime time, const scheduler::Answer& answer,
             std::vector<EstimateError>& out) {
  using Kind = EstimateError::Kind;
  const scheduler::Decision& decision = answer.decision;
  const Pose2 pose = truth.robot(answer.robot, time);
  const auto x_m = value_of(decision, "x_m"), y_m = value_of(decision, "y_m");
  if (x_m && y_m)
    out.push_back(
        {Kind::position_m, time, answer.robot, maths::length(*x_m - pose.x_m, *y_m - pose.y_m)});
  if (const auto theta_rad = value_of(decision, "theta_rad"))
    out.push_back(
        {Kind::heading_rad, time, answer.robot, maths::wrap_angle(*theta_rad - pose.theta_rad)});
  const Pose2 ball = truth.ball(time);
  const double dx_m = ball.x_m - pose.x_m, dy_m = ball.y_m - pose.y_m,
               distance_m = maths::length(dx_m, dy_m);
  if (const auto estimate = value_of(decision, "ball_distance_m"))
    out.push_back({Kind::ball_distance_m, time, answer.robot, *estimate - distance_m, distance_m});
  if (const auto estimate = value_of(decision, "ball_bearing_rad"))
    out.push_back({Kind::ball_bearing_rad, time, answer.robot,
                   maths::wrap_angle(*estimate - (maths::atan2(dy_m, dx_m) - pose.theta_rad)),
                   distance_m});
}

}  // namespace

std::vector<EstimateError> estimate_errors(const scheduler::Log& log, SimTime from) {
  const Truth truth(log);
  std::vector<EstimateError> errors;
  LogCursor cursor(log, {Topic::turn}, from);
  while (const auto record = cursor.next()) {
    const auto& turn = std::get<scheduler::TurnRecord>(*record);
    for (const scheduler::Answer& answer : turn.turn.answers)
      compare(truth, turn.time, answer, errors);
  }
  return errors;
}

ErrorSummary summarise(std::vector<double> errors) {
  ErrorSummary summary{.count = errors.size()};
  if (errors.empty()) return summary;
  const double n = static_cast<double>(errors.size());
  for (double& error : errors) {
    summary.mean += error / n;
    summary.rms += error * error / n;
    error = std::abs(error);
  }
  summary.rms = std::sqrt(summary.rms);
  std::sort(errors.begin(), errors.end());
  // The middle of two where the number is even; of the 90 % the smallest that so many do not
  // exceed.
  summary.median_abs = 0.5 * (errors[(errors.size() - 1) / 2] + errors[errors.size() / 2]);
  summary.p90_abs = errors[static_cast<size_t>(std::ceil(0.9 * n)) - 1];
  summary.max_abs = errors.back();
  return summary;
}

}  // namespace seam::app
