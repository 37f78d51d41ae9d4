#include "sim_core/world/sensors.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"

namespace seam {
namespace {

// The newest reading that had arrived by `time`; readings ascend in time and are never empty.
template <class Reading, class TimeOf>
const Reading& newest(const std::vector<Reading>& readings, SimDuration latency, SimTime time,
                      TimeOf time_of) {
  size_t i = readings.size() - 1;
  while (i > 0 && time_of(readings[i]) + latency > time) --i;
  return readings[i];
}

// Drops what is older than the newest delivered reading.
template <class Reading, class TimeOf>
void forget(std::vector<Reading>& readings, SimDuration latency, SimTime time, TimeOf time_of) {
  size_t keep = 0;
  while (keep + 1 < readings.size() && time_of(readings[keep + 1]) + latency <= time) ++keep;
  readings.erase(readings.begin(), readings.begin() + static_cast<std::ptrdiff_t>(keep));
}

constexpr auto kTime = [](const auto& reading) { return reading.time; };

// Whether a sensor samples at `time`: its clock ticks at phase + i * period.
bool samples_at(const SensorSpec& sensor, SimTime time) {
  const int64_t since_first = time.ns() - sensor.phase.ns();
  return since_first >= 0 && since_first % sensor.period.ns() == 0;
}

}  // namespace

SensorSuite::SensorSuite(const RobotSpec& robot, SimDuration memory, RandomStream stream,
                         std::shared_ptr<const ForceReading> force)
    : spec_(&robot.sensors), memory_(memory), stream_(stream), force_(std::move(force)) {
  if (force_) force_state_ = force_->first_state();
  const KinematicTree& tree = robot.body.tree;
  if (tree.present()) {
    tree_joints_ = static_cast<int>(tree.joint_count());
    kept_joints_ = std::max(kept_joints_, tree.joint_count());
  }
  joints_.resize(1);
  odometry_.resize(1);
  accelerations_.resize(1);
  paws_.resize(1);
  joints_[0].time = SimTime::from_ns(-(int64_t{1} << 60));  // Before any log.
}

std::vector<SimTime> SensorSuite::sampling_times(SimTime after, SimTime until) const {
  std::vector<SimTime> times;
  for (const SensorSpec* sensor :
       {&spec_->joints, &spec_->odometry, &spec_->accelerometer, &spec_->paws}) {
    const int64_t period = sensor->period.ns(), first = sensor->phase.ns();
    int64_t tick =
        after.ns() < first ? first : first + ((after.ns() - first) / period + 1) * period;
    for (; tick <= until.ns(); tick += period) times.push_back(SimTime::from_ns(tick));
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

void SensorSuite::sample(SimTime time, const SensorTruth& truth) {
  const auto tick = static_cast<uint64_t>(time.ns());
  if (samples_at(spec_->joints, time)) {
    JointReading reading{time, truth.encoders_rad};
    if (spec_->joints.sigma > 0) {
      const RandomStream noise = stream_.child("joints").child(tick);
      for (size_t j = 0; j < kept_joints_; ++j)
        reading.rad[j] += spec_->joints.sigma * normal(noise, j);
    }
    joints_.push_back(reading);
  }
  if (samples_at(spec_->odometry, time)) {
    const Pose2& now = truth.dead_reckoning;
    const double way =
        maths::length(now.x_m - last_dead_reckoning_.x_m, now.y_m - last_dead_reckoning_.y_m);
    const double turn = std::abs(now.theta_rad - last_dead_reckoning_.theta_rad);
    const RandomStream noise = stream_.child("odometry").child(tick);
    if (spec_->odometry.sigma > 0 && way + turn > 0) {
      odometry_error_.x_m += spec_->odometry.sigma * std::sqrt(way) * normal(noise, 0);
      odometry_error_.y_m += spec_->odometry.sigma * std::sqrt(way) * normal(noise, 1);
      odometry_error_.theta_rad += spec_->odometry.sigma * std::sqrt(turn) * normal(noise, 2);
    }
    last_dead_reckoning_ = now;
    odometry_.push_back({time,
                         {now.x_m + odometry_error_.x_m, now.y_m + odometry_error_.y_m,
                          maths::wrap_angle(now.theta_rad + odometry_error_.theta_rad)}});
  }
  if (samples_at(spec_->accelerometer, time)) {
    const RandomStream noise = stream_.child("accelerometer").child(tick);
    Vec3 value = truth.specific_force_B;
    const double sigma = spec_->accelerometer.sigma;
    if (sigma > 0) value += sigma * Vec3(normal(noise, 0), normal(noise, 1), normal(noise, 2));
    if (force_) value = force_->reading(value, time, force_state_);
    accelerations_.push_back({time, value});
  }
  if (samples_at(spec_->paws, time)) {
    Paws reading{time, truth.paw_contact};
    const RandomStream noise = stream_.child("paws").child(tick);
    for (size_t i = 0; i < kLegs; ++i) {
      if (spec_->paws.sigma > 0 && uniform(noise, i) < spec_->paws.sigma)
        reading.value[i] = !reading.value[i];
    }
    paws_.push_back(reading);
  }
  forget_old(time);
}

void SensorSuite::forget_old(SimTime time) {
  forget(odometry_, spec_->odometry.latency, time, kTime);
  forget(accelerations_, spec_->accelerometer.latency, time, kTime);
  forget(paws_, spec_->paws.latency, time, kTime);
  forget(joints_, spec_->joints.latency + memory_, time, kTime);
}

RobotSensors SensorSuite::read(SimTime time, SimTime since) const {
  RobotSensors sensors;
  sensors.time = time;
  sensors.tree_joints = tree_joints_;
  const SimDuration latency = spec_->joints.latency;
  sensors.joints = newest(joints_, latency, time, kTime);
  for (const JointReading& reading : joints_) {
    const SimTime delivered = reading.time + latency;
    if (delivered > since && delivered <= time) sensors.joint_log.push_back(reading);
  }
  const Odometry& odometry = newest(odometry_, spec_->odometry.latency, time, kTime);
  sensors.odometry_time = odometry.time;
  sensors.odometry = odometry.value;
  const Acceleration& acceleration =
      newest(accelerations_, spec_->accelerometer.latency, time, kTime);
  sensors.acceleration_time = acceleration.time;
  sensors.acceleration_m_s2 = acceleration.value;
  const Paws& paws = newest(paws_, spec_->paws.latency, time, kTime);
  sensors.paws_time = paws.time;
  sensors.paw_contact = paws.value;
  return sensors;
}

void SensorSuite::Acceleration::visit(StateVisitor& visitor) {
  visitor.field("acceleration_time", time);
  visitor.field("acceleration_x", value.x);
  visitor.field("acceleration_y", value.y);
  visitor.field("acceleration_z", value.z);
}

void SensorSuite::Odometry::visit(StateVisitor& visitor) {
  visitor.field("odometry_time", time);
  visitor.field("odometry_x_m", value.x_m);
  visitor.field("odometry_y_m", value.y_m);
  visitor.field("odometry_theta_rad", value.theta_rad);
}

void SensorSuite::Paws::visit(StateVisitor& visitor) {
  visitor.field("paws_time", time);
  for (bool& contact : value) visitor.field("paw_contact", contact);
}

void SensorSuite::visit(StateVisitor& visitor) {
  joints_.resize(visitor.list_size("joint_readings", joints_.size()));
  for (JointReading& reading : joints_) {
    visitor.field("joints_time", reading.time);
    for (size_t j = 0; j < kept_joints_; ++j) visitor.field("joints_rad", reading.rad[j]);
  }
  visitor.list("odometry_readings", odometry_);
  visitor.list("acceleration_readings", accelerations_);
  visitor.list("paw_readings", paws_);
  if (joints_.empty() || odometry_.empty() || accelerations_.empty() || paws_.empty()) {
    throw InputError("snapshot: a sensor without readings");
  }
  for (double& part : force_state_) visitor.field("accelerometer_state", part);
  visitor.field("odometry_error_x_m", odometry_error_.x_m);
  visitor.field("odometry_error_y_m", odometry_error_.y_m);
  visitor.field("odometry_error_theta_rad", odometry_error_.theta_rad);
  visitor.field("dead_x_m", last_dead_reckoning_.x_m);
  visitor.field("dead_y_m", last_dead_reckoning_.y_m);
  visitor.field("dead_theta_rad", last_dead_reckoning_.theta_rad);
}

}  // namespace seam
