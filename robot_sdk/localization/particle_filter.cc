#include "robot_sdk/localization/particle_filter.h"

#include <Random123/philox.h>

#include <algorithm>
#include <cmath>

namespace seam::sdk {
namespace {

constexpr float kPi = 3.14159265f;
constexpr int kMemory =
    25;  // Updates for which a landmark's place in the body frame is remembered.
// Two landmarks whose seen distance is this much off, in part, are not both where they seem.
constexpr float kPairTolerance = 0.2f;
constexpr double kFitOfTheFound = 0.4;
constexpr double kMostRenewed = 0.25;  // Of the samples, in one update.
constexpr double kMostRenewedByOne =
    0.05;  // The same where a single landmark is all there is to go by.
constexpr float kSeedSigma_m = 0.10f, kSeedSigma_rad = 0.08f;  // Of a pose from two landmarks.

float wrap(float angle) {
  return angle - 2 * kPi * std::round(angle / (2 * kPi));
}

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

ParticleFilter::ParticleFilter(const ParticleFilterOptions& options,
                               std::vector<LandmarkPosition> landmarks)
    : options_(options), landmarks_(std::move(landmarks)), samples_(options.particles) {
  for (FieldPose& pose : samples_) {
    pose.x_m = (2 * uniform() - 1) * options_.half_length_m;
    pose.y_m = (2 * uniform() - 1) * options_.half_width_m;
    pose.theta_rad = (2 * uniform() - 1) * kPi;
  }
}

float ParticleFilter::uniform() {
  const philox4x32_ctr_t counter = {
      {static_cast<uint32_t>(draws_), static_cast<uint32_t>(draws_ >> 32), 0, 0}};
  const philox4x32_key_t key = {
      {static_cast<uint32_t>(options_.seed), static_cast<uint32_t>(options_.seed >> 32)}};
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
  const auto blocked =
      static_cast<size_t>(options_.blocked_share * static_cast<float>(samples_.size()));
  for (size_t i = 0; i < samples_.size(); ++i) {
    FieldPose& pose = samples_[i];
    const float heading = pose.theta_rad + 0.5f * dtheta_rad;
    const float c = std::cos(heading), s = std::sin(heading);
    const float part =
        i * blocked / samples_.size() != (i + 1) * blocked / samples_.size() ? uniform() : 1.0f;
    const float dx = part * dx_m + sigma_m * normal();
    const float dy = part * dy_m + sigma_m * normal();
    pose.x_m =
        std::clamp(pose.x_m + c * dx - s * dy, -options_.half_length_m, options_.half_length_m);
    pose.y_m =
        std::clamp(pose.y_m + s * dx + c * dy, -options_.half_width_m, options_.half_width_m);
    pose.theta_rad = wrap(pose.theta_rad + part * dtheta_rad + sigma_rad * normal());
  }
  const float c = std::cos(dtheta_rad), s = std::sin(dtheta_rad);
  for (Remembered& seen : remembered_) {
    const float x = seen.x_m - dx_m, y = seen.y_m - dy_m;
    seen.x_m = c * x + s * y, seen.y_m = -s * x + c * y;
    ++seen.age;
  }
  std::erase_if(remembered_, [](const Remembered& seen) { return seen.age > kMemory; });
}

void ParticleFilter::place(const std::vector<FieldPose>& poses, float share, float sigma_m,
                           float sigma_rad) {
  const auto placed = static_cast<size_t>(share * static_cast<float>(samples_.size()));
  remembered_.clear();
  for (size_t i = 0, k = 0; i < samples_.size() && !poses.empty(); ++i) {
    if (i * placed / samples_.size() == (i + 1) * placed / samples_.size()) continue;
    const FieldPose& pose = poses[k++ % poses.size()];
    samples_[i] = on_field({pose.x_m + sigma_m * normal(), pose.y_m + sigma_m * normal(),
                            wrap(pose.theta_rad + sigma_rad * normal())});
  }
}

FieldPose ParticleFilter::on_field(FieldPose pose) const {
  pose.x_m = std::clamp(pose.x_m, -options_.half_length_m, options_.half_length_m);
  pose.y_m = std::clamp(pose.y_m, -options_.half_width_m, options_.half_width_m);
  return pose;
}

const LandmarkPosition* ParticleFilter::position_of(LandmarkKind kind) const {
  const auto found =
      std::find_if(landmarks_.begin(), landmarks_.end(),
                   [&](const LandmarkPosition& landmark) { return landmark.kind == kind; });
  return found == landmarks_.end() ? nullptr : &*found;
}

ParticleFilter::Fit ParticleFilter::fit_of(const FieldPose& pose,
                                           const LandmarkSighting& sighting) const {
  const LandmarkPosition* landmark = position_of(sighting.kind);
  if (landmark == nullptr) return {1, 1};
  const float dx = landmark->x_m - pose.x_m, dy = landmark->y_m - pose.y_m;
  const float bearing_error = wrap(std::atan2(dy, dx) - pose.theta_rad - sighting.bearing_rad);
  const float bearing_sigma = sighting.bearing_sigma_rad + options_.bearing_floor_rad;
  const float bearing_exponent = bearing_error * bearing_error / (bearing_sigma * bearing_sigma);
  const auto with_outliers = [](float likelihood, float outliers) {
    return (1 - outliers) * likelihood + outliers;
  };
  const float bearing =
      with_outliers(std::exp(-0.5f * bearing_exponent), options_.outlier_probability);
  if (!(sighting.range_m > 0)) return {bearing, bearing};
  const float range_error = std::sqrt(dx * dx + dy * dy) - sighting.range_m;
  const float range_sigma =
      sighting.range_sigma_m + options_.range_floor_fraction * sighting.range_m;
  const float range_exponent = range_error * range_error / (range_sigma * range_sigma);
  if (options_.range_outlier_probability == 0) {
    return {bearing, with_outliers(std::exp(-0.5f * (bearing_exponent + range_exponent)),
                                   options_.outlier_probability)};
  }
  const float range =
      with_outliers(std::exp(-0.5f * range_exponent), options_.range_outlier_probability);
  return {bearing,
          with_outliers(std::exp(-0.5f * bearing_exponent) * range, options_.outlier_probability)};
}

void ParticleFilter::observe(const std::vector<LandmarkSighting>& sightings) {
  if (sightings.empty()) return;
  remember(sightings);
  std::vector<float> weights(samples_.size(), 1.0f);
  double renewed = 0;
  for (const LandmarkSighting& sighting : sightings) {
    double bearing_fit = 0;
    for (size_t i = 0; i < samples_.size(); ++i) {
      const Fit fit = fit_of(samples_[i], sighting);
      weights[i] *= fit.both;
      bearing_fit += fit.bearing;
    }
    renewed = share_to_renew(bearing_fit / static_cast<double>(samples_.size()));
  }
  resample(weights, sightings, renewed);
}

// By bearings alone: a range is often wrong while the robot knows where it is. A filter that never
// found its place has nothing better to compare with, so what sightings fit at least once it is
// found counts too.
double ParticleFilter::share_to_renew(double fit) {
  slow_fit_ += options_.slow_rate * (fit - slow_fit_);
  fast_fit_ += options_.fast_rate * (fit - fast_fit_);
  return std::max(0.0, 1 - fast_fit_ / std::max(slow_fit_, kFitOfTheFound));
}

void ParticleFilter::remember(const std::vector<LandmarkSighting>& sightings) {
  for (const LandmarkSighting& sighting : sightings) {
    // A goal's range is a guess while robots stand before it.
    const bool is_goal =
        sighting.kind == LandmarkKind::goal_yellow || sighting.kind == LandmarkKind::goal_skyblue;
    if (is_goal || sighting.range_m == 0 || position_of(sighting.kind) == nullptr) continue;
    std::erase_if(remembered_, [&](const Remembered& seen) { return seen.kind == sighting.kind; });
    remembered_.push_back({sighting.kind, sighting.range_m * std::cos(sighting.bearing_rad),
                           sighting.range_m * std::sin(sighting.bearing_rad), 0});
  }
}

std::vector<FieldPose> ParticleFilter::poses_from_pairs() const {
  std::vector<FieldPose> poses;
  for (size_t i = 0; i < remembered_.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const Remembered &a = remembered_[i], &b = remembered_[j];
      const LandmarkPosition &at_a = *position_of(a.kind), &at_b = *position_of(b.kind);
      const float dx = at_b.x_m - at_a.x_m, dy = at_b.y_m - at_a.y_m;
      const float seen_dx = b.x_m - a.x_m, seen_dy = b.y_m - a.y_m;
      const float apart = std::sqrt(dx * dx + dy * dy),
                  seen_apart = std::sqrt(seen_dx * seen_dx + seen_dy * seen_dy);
      if (std::abs(seen_apart - apart) > kPairTolerance * apart) continue;
      // The turn that lays the seen line from a to b along the true one; then the middles of both
      // are one.
      const float theta = wrap(std::atan2(dy, dx) - std::atan2(seen_dy, seen_dx));
      const float c = std::cos(theta), s = std::sin(theta);
      const float x = 0.5f * (a.x_m + b.x_m), y = 0.5f * (a.y_m + b.y_m);
      poses.push_back({0.5f * (at_a.x_m + at_b.x_m) - (c * x - s * y),
                       0.5f * (at_a.y_m + at_b.y_m) - (s * x + c * y), theta});
    }
  }
  return poses;
}

FieldPose ParticleFilter::pose_from(const LandmarkSighting& sighting) {
  const LandmarkPosition& landmark = *position_of(sighting.kind);
  const float range = sighting.range_m * (1 + options_.range_floor_fraction * normal());
  const float around = (2 * uniform() - 1) * kPi;  // Direction from the landmark to the robot.
  FieldPose pose{landmark.x_m + range * std::cos(around), landmark.y_m + range * std::sin(around),
                 0};
  pose.theta_rad =
      wrap(around + kPi - sighting.bearing_rad + options_.bearing_floor_rad * normal());
  return pose;
}

// One landmark gives the heading of a robot that knows its place.
FieldPose ParticleFilter::turned_towards(FieldPose pose, const LandmarkSighting& sighting) {
  const LandmarkPosition& landmark = *position_of(sighting.kind);
  const float direction = std::atan2(landmark.y_m - pose.y_m, landmark.x_m - pose.x_m);
  pose.theta_rad = wrap(direction - sighting.bearing_rad + options_.bearing_floor_rad * normal());
  return pose;
}

void ParticleFilter::resample(const std::vector<float>& weights,
                              const std::vector<LandmarkSighting>& sightings, double renewed) {
  double total = 0;
  for (float weight : weights) total += weight;
  const size_t count = samples_.size();
  std::vector<const LandmarkSighting*> usable;
  for (const LandmarkSighting& sighting : sightings) {
    if (sighting.range_m > 0 && position_of(sighting.kind) != nullptr) usable.push_back(&sighting);
  }
  std::vector<FieldPose> seeds;
  if (options_.fast_rate == 0) {
    // Where the samples explain what was seen badly on average, some are drawn from a sighting.
    const double fit = total / static_cast<double>(count);
    renewed = options_.reset_fraction * std::max(0.0, 1 - fit / 0.2);
  } else {
    seeds = poses_from_pairs();
    renewed = std::min(renewed, seeds.empty() ? kMostRenewedByOne : kMostRenewed);
  }
  const size_t fresh =
      usable.empty() ? 0 : static_cast<size_t>(renewed * static_cast<double>(count));
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
    const LandmarkSighting& sighting = *usable[k % usable.size()];
    if (options_.fast_rate == 0 || (seeds.empty() && k % 4 == 0)) {
      drawn.push_back(on_field(pose_from(sighting)));
    } else if (seeds.empty()) {
      const auto any = static_cast<size_t>(uniform() * static_cast<float>(count));
      drawn.push_back(turned_towards(samples_[std::min(count - 1, any)], sighting));
    } else {
      const FieldPose& seed = seeds[k % seeds.size()];
      drawn.push_back(
          on_field({seed.x_m + kSeedSigma_m * normal(), seed.y_m + kSeedSigma_m * normal(),
                    wrap(seed.theta_rad + kSeedSigma_rad * normal())}));
    }
  }
  samples_ = std::move(drawn);
}

PoseEstimate ParticleFilter::estimate() const {
  return estimate_of(samples_);
}

PoseEstimate ParticleFilter::densest() const {
  constexpr size_t kCandidates = 40;
  constexpr float kNear_m = 0.35f, kNear_rad = 0.6f;
  const auto near = [&](const FieldPose& a, const FieldPose& b) {
    const float dx = a.x_m - b.x_m, dy = a.y_m - b.y_m;
    return dx * dx + dy * dy < kNear_m * kNear_m &&
           std::abs(wrap(a.theta_rad - b.theta_rad)) < kNear_rad;
  };
  FieldPose best;
  std::ptrdiff_t most = 0;
  for (size_t i = 0; i < samples_.size(); i += std::max<size_t>(1, samples_.size() / kCandidates)) {
    const auto count = std::count_if(samples_.begin(), samples_.end(),
                                     [&](const FieldPose& p) { return near(p, samples_[i]); });
    if (count > most) most = count, best = samples_[i];
  }
  std::vector<FieldPose> around;
  for (const FieldPose& pose : samples_) {
    if (near(pose, best)) around.push_back(pose);
  }
  return estimate_of(around);
}

PoseEstimate ParticleFilter::estimate_of(const std::vector<FieldPose>& samples) {
  double x = 0, y = 0, c = 0, s = 0;
  for (const FieldPose& pose : samples) {
    x += pose.x_m, y += pose.y_m, c += std::cos(pose.theta_rad), s += std::sin(pose.theta_rad);
  }
  const double n = static_cast<double>(samples.size());
  PoseEstimate result;
  result.mean = {static_cast<float>(x / n), static_cast<float>(y / n),
                 std::atan2(static_cast<float>(s / n), static_cast<float>(c / n))};
  std::vector<float> xs, ys, turns;
  double square = 0;
  for (const FieldPose& pose : samples) {
    xs.push_back(pose.x_m), ys.push_back(pose.y_m),
        turns.push_back(wrap(pose.theta_rad - result.mean.theta_rad));
    const double dx = pose.x_m - result.mean.x_m, dy = pose.y_m - result.mean.y_m;
    square += dx * dx + dy * dy;
  }
  result.spread_xy_m = static_cast<float>(std::sqrt(square / n));
  const auto in_order = [](std::vector<float>& values, double part) {
    const auto nth =
        values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  const auto bounds = [&](std::vector<float>& values, float& low, float& high) {
    low = in_order(values, 0.025), high = in_order(values, 0.975);
  };
  bounds(xs, result.low.x_m, result.high.x_m);
  bounds(ys, result.low.y_m, result.high.y_m);
  bounds(turns, result.low.theta_rad, result.high.theta_rad);
  result.low.theta_rad += result.mean.theta_rad;
  result.high.theta_rad += result.mean.theta_rad;
  return result;
}

}  // namespace seam::sdk
