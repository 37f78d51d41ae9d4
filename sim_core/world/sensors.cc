#include "sim_core/world/sensors.h"

#include <algorithm>
#include <cmath>

#include "sim_core/base/error.h"
#include "sim_core/base/maths.h"
#include "sim_core/world/world.h"

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

constexpr SensorSuite::InertialSensor::Names SensorSuite::InertialSensor::kAccelerometer = {
    "accelerometer",  "acceleration_readings", "acceleration_time",  "acceleration_x",
    "acceleration_y", "acceleration_z",        "accelerometer_state"};
constexpr SensorSuite::InertialSensor::Names SensorSuite::InertialSensor::kGyroscope = {
    "gyroscope",          "angular_velocity_readings", "angular_velocity_time",
    "angular_velocity_x", "angular_velocity_y",        "angular_velocity_z",
    "gyroscope_state"};

SensorSuite::InertialSensor::InertialSensor(const SensorSpec& spec, const Names& names,
                                            Vec3 BodyMotion::*measured,
                                            std::shared_ptr<const InertialReading> effects)
    : spec_(&spec),
      names_(&names),
      measured_(measured),
      effects_(std::move(effects)),
      readings_(1) {
  if (effects_) effects_state_ = effects_->first_state();
}

void SensorSuite::InertialSensor::sample(SimTime time, const BodyMotion& motion,
                                         const RandomStream& noise_of_all) {
  if (!samples_at(*spec_, time)) return;
  const RandomStream noise =
      noise_of_all.child(names_->sensor).child(static_cast<uint64_t>(time.ns()));
  BodyMotion noisy = motion;
  Vec3& value = noisy.*measured_;
  const double sigma = spec_->sigma;
  if (sigma > 0) value += sigma * Vec3(normal(noise, 0), normal(noise, 1), normal(noise, 2));
  readings_.push_back({time, effects_ ? effects_->reading(noisy, time, effects_state_) : value});
}

const SensorSuite::Triad& SensorSuite::InertialSensor::newest_at(SimTime time) const {
  return newest(readings_, spec_->latency, time, kTime);
}

void SensorSuite::InertialSensor::forget_old(SimTime time) {
  forget(readings_, spec_->latency, time, kTime);
}

void SensorSuite::InertialSensor::visit_readings(StateVisitor& visitor) {
  readings_.resize(visitor.list_size(names_->readings, readings_.size()));
  for (Triad& reading : readings_) {
    visitor.field(names_->time, reading.time);
    visitor.field(names_->x, reading.value.x);
    visitor.field(names_->y, reading.value.y);
    visitor.field(names_->z, reading.value.z);
  }
  if (readings_.empty()) throw InputError("snapshot: a sensor without readings");
}

void SensorSuite::InertialSensor::visit_effects(StateVisitor& visitor) {
  for (double& part : effects_state_) visitor.field(names_->effects_state, part);
}

SensorSuite::SensorSuite(const RobotSpec& robot, SimDuration memory, const RandomStream& stream,
                         const RobotPartsFactory& parts)
    : spec_(&robot.sensors),
      memory_(memory),
      stream_(stream.child("sensors")),
      accelerometer_(spec_->accelerometer, InertialSensor::kAccelerometer, &BodyMotion::force_mps2,
                     parts.accelerometer(robot, stream.child("accelerometer_effects"))) {
  if (spec_->gyroscope)
    gyroscope_.emplace(*spec_->gyroscope, InertialSensor::kGyroscope, &BodyMotion::rate_radps,
                       parts.gyroscope(robot, stream.child("gyroscope_effects")));
  const KinematicTree& tree = robot.body.tree;
  if (tree.present()) {
    tree_joints_ = static_cast<int>(tree.joint_count());
    kept_joints_ = std::max(kept_joints_, tree.joint_count());
  }
  joints_.resize(1);
  odometry_.resize(1);
  paws_.resize(1);
  joints_[0].time = SimTime::from_ns(-(int64_t{1} << 60));  // Before any log.
}

std::vector<SimTime> SensorSuite::sampling_times(SimTime after, SimTime until) const {
  std::vector<SimTime> times;
  for (const SensorSpec* sensor : {&spec_->joints, &spec_->odometry, &spec_->accelerometer,
                                   &spec_->paws, gyroscope_ ? &gyroscope_->spec() : nullptr}) {
    if (!sensor) continue;
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
  accelerometer_.sample(time, truth.motion_B, stream_);
  if (gyroscope_) gyroscope_->sample(time, truth.motion_B, stream_);
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
  accelerometer_.forget_old(time);
  if (gyroscope_) gyroscope_->forget_old(time);
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
  const Triad& acceleration = accelerometer_.newest_at(time);
  sensors.acceleration_time = acceleration.time;
  sensors.acceleration_m_s2 = acceleration.value;
  if (gyroscope_) {
    const Triad& rate = gyroscope_->newest_at(time);
    sensors.angular_velocity_time = rate.time;
    sensors.angular_velocity_rad_s = rate.value;
  }
  const Paws& paws = newest(paws_, spec_->paws.latency, time, kTime);
  sensors.paws_time = paws.time;
  sensors.paw_contact = paws.value;
  return sensors;
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
  accelerometer_.visit_readings(visitor);
  visitor.list("paw_readings", paws_);
  if (joints_.empty() || odometry_.empty() || paws_.empty()) {
    throw InputError("snapshot: a sensor without readings");
  }
  accelerometer_.visit_effects(visitor);
  visitor.field("odometry_error_x_m", odometry_error_.x_m);
  visitor.field("odometry_error_y_m", odometry_error_.y_m);
  visitor.field("odometry_error_theta_rad", odometry_error_.theta_rad);
  visitor.field("dead_x_m", last_dead_reckoning_.x_m);
  visitor.field("dead_y_m", last_dead_reckoning_.y_m);
  visitor.field("dead_theta_rad", last_dead_reckoning_.theta_rad);
  if (!gyroscope_) return;
  gyroscope_->visit_readings(visitor);
  gyroscope_->visit_effects(visitor);
}

}  // namespace seam
