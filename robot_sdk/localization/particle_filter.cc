#include "robot_sdk/localization/particle_filter.h"

#include <Random123/philox.h>

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kPi = 3.14159265f;

float wrap(float angle) { return angle - 2 * kPi * std::round(angle / (2 * kPi)); }

}  // namespace

std::vector<LandmarkPosition> standard_landmarks(bool swap_ends) {
  // On y = +1.45 m pink is the lower band, on y = -1.45 m the upper.
  const float skyblue_x = swap_ends ? -2.2f : 2.2f;
  return {{LandmarkKind::beacon_skyblue_pink_low, skyblue_x, 1.45f},
          {LandmarkKind::beacon_skyblue_pink_high, skyblue_x, -1.45f},
          {LandmarkKind::beacon_yellow_pink_low, -skyblue_x, 1.45f},
          {LandmarkKind::beacon_yellow_pink_high, -skyblue_x, -1.45f},
          {LandmarkKind::beacon_green_pink_low, 0, 1.45f},
          {LandmarkKind::beacon_green_pink_high, 0, -1.45f},
          {LandmarkKind::goal_skyblue, 2.25f, 0},
          {LandmarkKind::goal_yellow, -2.25f, 0}};
}

ParticleFilter::ParticleFilter(const ParticleFilterOptions& options, std::vector<LandmarkPosition> landmarks)
    : options_(options), landmarks_(std::move(landmarks)), samples_(options.particles) {
  for (FieldPose& pose : samples_) {
    pose.x_m = (2 * uniform() - 1) * options_.half_length_m;
    pose.y_m = (2 * uniform() - 1) * options_.half_width_m;
    pose.theta_rad = (2 * uniform() - 1) * kPi;
  }
}

float ParticleFilter::uniform() {
  const philox4x32_ctr_t counter = {{static_cast<uint32_t>(draws_), static_cast<uint32_t>(draws_ >> 32), 0, 0}};
  const philox4x32_key_t key = {{static_cast<uint32_t>(options_.seed), static_cast<uint32_t>(options_.seed >> 32)}};
  ++draws_;
  return (static_cast<float>(philox4x32(counter, key)[0] >> 8) + 0.5f) * 0x1p-24f;
}

float ParticleFilter::normal() {
  const float radius = std::sqrt(-2 * std::log(uniform()));
  return radius * std::cos(2 * kPi * uniform());
}

void ParticleFilter::move(float dx_m, float dy_m, float dtheta_rad) {
  const float step = std::sqrt(dx_m * dx_m + dy_m * dy_m);
  const float sigma_m = options_.motion_fraction * step + options_.jitter_m;
  const float sigma_rad = options_.motion_fraction * std::abs(dtheta_rad) + options_.jitter_rad;
  for (FieldPose& pose : samples_) {
    const float heading = pose.theta_rad + 0.5f * dtheta_rad;
    const float c = std::cos(heading), s = std::sin(heading);
    const float dx = dx_m + sigma_m * normal();
    const float dy = dy_m + sigma_m * normal();
    pose.x_m = std::clamp(pose.x_m + c * dx - s * dy, -options_.half_length_m, options_.half_length_m);
    pose.y_m = std::clamp(pose.y_m + s * dx + c * dy, -options_.half_width_m, options_.half_width_m);
    pose.theta_rad = wrap(pose.theta_rad + dtheta_rad + sigma_rad * normal());
  }
}

const LandmarkPosition* ParticleFilter::position_of(LandmarkKind kind) const {
  const auto found = std::find_if(landmarks_.begin(), landmarks_.end(),
                                  [&](const LandmarkPosition& landmark) { return landmark.kind == kind; });
  return found == landmarks_.end() ? nullptr : &*found;
}

float ParticleFilter::likelihood(const FieldPose& pose, const LandmarkSighting& sighting) const {
  const LandmarkPosition* landmark = position_of(sighting.kind);
  if (landmark == nullptr) return 1;
  const float dx = landmark->x_m - pose.x_m, dy = landmark->y_m - pose.y_m;
  const float bearing_error = wrap(std::atan2(dy, dx) - pose.theta_rad - sighting.bearing_rad);
  const float bearing_sigma = sighting.bearing_sigma_rad + options_.bearing_floor_rad;
  float exponent = bearing_error * bearing_error / (bearing_sigma * bearing_sigma);
  if (sighting.range_m > 0) {
    const float range_error = std::sqrt(dx * dx + dy * dy) - sighting.range_m;
    const float range_sigma = sighting.range_sigma_m + options_.range_floor_fraction * sighting.range_m;
    exponent += range_error * range_error / (range_sigma * range_sigma);
  }
  return (1 - options_.outlier_probability) * std::exp(-0.5f * exponent) + options_.outlier_probability;
}

void ParticleFilter::observe(const std::vector<LandmarkSighting>& sightings) {
  if (sightings.empty()) return;
  std::vector<float> weights;
  weights.reserve(samples_.size());
  for (const FieldPose& pose : samples_) {
    float weight = 1;
    for (const LandmarkSighting& sighting : sightings) weight *= likelihood(pose, sighting);
    weights.push_back(weight);
  }
  resample(weights, sightings);
}

FieldPose ParticleFilter::pose_from(const LandmarkSighting& sighting) {
  const LandmarkPosition& landmark = *position_of(sighting.kind);
  const float range = sighting.range_m * (1 + options_.range_floor_fraction * normal());
  const float around = (2 * uniform() - 1) * kPi;  // Direction from the landmark to the robot.
  FieldPose pose{landmark.x_m + range * std::cos(around), landmark.y_m + range * std::sin(around), 0};
  pose.theta_rad = wrap(around + kPi - sighting.bearing_rad + options_.bearing_floor_rad * normal());
  return pose;
}

void ParticleFilter::resample(const std::vector<float>& weights, const std::vector<LandmarkSighting>& sightings) {
  double total = 0;
  for (float weight : weights) total += weight;
  const size_t count = samples_.size();
  // Where the samples explain what was seen badly on average, some are drawn from a sighting.
  const double fit = total / static_cast<double>(count);
  std::vector<const LandmarkSighting*> usable;
  for (const LandmarkSighting& sighting : sightings) {
    if (sighting.range_m > 0 && position_of(sighting.kind) != nullptr) usable.push_back(&sighting);
  }
  const double badness = std::max(0.0, 1 - fit / 0.2);
  const size_t fresh = usable.empty() ? 0 : static_cast<size_t>(options_.reset_fraction * badness * count);
  std::vector<FieldPose> drawn;
  drawn.reserve(count);
  // Low-variance resampling: one random number, equal steps.
  const double step = total / static_cast<double>(count - fresh);
  double target = step * uniform();
  double cumulative = weights[0];
  size_t i = 0;
  while (drawn.size() + fresh < count) {
    while (cumulative < target && i + 1 < count) cumulative += weights[++i];
    drawn.push_back(samples_[i]);
    target += step;
  }
  for (size_t k = 0; k < fresh; ++k) {
    FieldPose pose = pose_from(*usable[k % usable.size()]);
    pose.x_m = std::clamp(pose.x_m, -options_.half_length_m, options_.half_length_m);
    pose.y_m = std::clamp(pose.y_m, -options_.half_width_m, options_.half_width_m);
    drawn.push_back(pose);
  }
  samples_ = std::move(drawn);
}

PoseEstimate ParticleFilter::estimate() const {
  double x = 0, y = 0, c = 0, s = 0;
  for (const FieldPose& pose : samples_) {
    x += pose.x_m, y += pose.y_m, c += std::cos(pose.theta_rad), s += std::sin(pose.theta_rad);
  }
  const double n = static_cast<double>(samples_.size());
  PoseEstimate result;
  result.mean = {static_cast<float>(x / n), static_cast<float>(y / n),
                 std::atan2(static_cast<float>(s / n), static_cast<float>(c / n))};
  std::vector<float> xs, ys, turns;
  double square = 0;
  for (const FieldPose& pose : samples_) {
    xs.push_back(pose.x_m), ys.push_back(pose.y_m), turns.push_back(wrap(pose.theta_rad - result.mean.theta_rad));
    const double dx = pose.x_m - result.mean.x_m, dy = pose.y_m - result.mean.y_m;
    square += dx * dx + dy * dy;
  }
  result.spread_xy_m = static_cast<float>(std::sqrt(square / n));
  const auto bounds = [](std::vector<float>& values, float& low, float& high) {
    std::sort(values.begin(), values.end());
    low = values[static_cast<size_t>(0.025 * static_cast<double>(values.size() - 1))];
    high = values[static_cast<size_t>(0.975 * static_cast<double>(values.size() - 1))];
  };
  bounds(xs, result.low.x_m, result.high.x_m);
  bounds(ys, result.low.y_m, result.high.y_m);
  bounds(turns, result.low.theta_rad, result.high.theta_rad);
  result.low.theta_rad += result.mean.theta_rad;
  result.high.theta_rad += result.mean.theta_rad;
  return result;
}

}  // namespace seam::sdk
