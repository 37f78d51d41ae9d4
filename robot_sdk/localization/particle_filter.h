// Monte Carlo localisation on the field from ranges and bearings of landmarks (Fox et al. 1999,
// with sensor resetting after Lenser and Veloso 2000).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "robot_sdk/vision/landmark_detector.h"

namespace seam::sdk {

struct FieldPose {
  float x_m = 0;
  float y_m = 0;
  float theta_rad = 0;
};

struct LandmarkPosition {
  LandmarkKind kind;
  float x_m;
  float y_m;
};

// The 2002/2003 field with the sky-blue goal at +x; `swap_ends` where the beacons' end colours are
// the other way round (sources disagree).
std::vector<LandmarkPosition> standard_landmarks(bool swap_ends = false);

struct ParticleFilterOptions {
  int particles = 1000;
  uint64_t seed = 1;
  float half_length_m = 2.1f;  // Particles stay on the field.
  float half_width_m = 1.35f;
  // The sensor model is wider than a single sighting's own spread: body height, gait and colour
  // edges are not known exactly.
  float bearing_floor_rad = 0.03f;
  float range_floor_fraction = 0.10f;
  float outlier_probability = 0.05f;  // Of a sighting that fits nowhere.
  // Spread of the motion update: a part of the motion, and a jitter for each update.
  float motion_fraction = 0.15f;
  float jitter_m = 0.010f;
  float jitter_rad = 0.010f;
  float reset_fraction = 0.02f;  // Particles drawn anew from a sighting, at most, an update.
};

struct PoseEstimate {
  FieldPose mean;
  // The interval that the samples cover without the outermost 2.5 % on each side.
  FieldPose low;
  FieldPose high;
  float spread_xy_m = 0;
};

class ParticleFilter {
 public:
  explicit ParticleFilter(const ParticleFilterOptions& options, std::vector<LandmarkPosition> landmarks);

  // Moves all samples by a motion in the body frame.
  void move(float dx_m, float dy_m, float dtheta_rad);
  // Weighs the samples by what was seen, then draws them anew.
  void observe(const std::vector<LandmarkSighting>& sightings);

  PoseEstimate estimate() const;
  const std::vector<FieldPose>& samples() const { return samples_; }

 private:
  float likelihood(const FieldPose& pose, const LandmarkSighting& sighting) const;
  const LandmarkPosition* position_of(LandmarkKind kind) const;
  void resample(const std::vector<float>& weights, const std::vector<LandmarkSighting>& sightings);
  FieldPose pose_from(const LandmarkSighting& sighting);
  float uniform();
  float normal();

  ParticleFilterOptions options_;
  std::vector<LandmarkPosition> landmarks_;
  std::vector<FieldPose> samples_;
  uint64_t draws_ = 0;  // Index of the next random number.
};

}  // namespace seam::sdk
