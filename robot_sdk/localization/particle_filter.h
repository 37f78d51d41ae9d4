// Monte Carlo localisation on the field from ranges and bearings of landmarks (Fox et al. 1999,
// with sensor resetting after Lenser and Veloso 2000). For robots that are carried and pushed there
// is the augmented filter of Thrun, Burgard and Fox (Probabilistic Robotics, 2005, ch. 8.3.5):
// samples are drawn anew as far as what is seen now is explained worse than what was seen before.
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
  // Of a range that is wrong though the bearing is right: a band half hidden, an edge that no
  // colour claims. 0: ranges are as good as bearings.
  float range_outlier_probability = 0;
  // Spread of the motion update: a part of the motion, and a jitter for each update.
  float motion_fraction = 0.15f;
  float jitter_m = 0.010f;
  float jitter_rad = 0.010f;
  float reset_fraction = 0.02f;  // Particles drawn anew from a sighting, at most, an update.
  // The augmented filter's alpha_slow and alpha_fast, a sighting; 0: the share of new particles
  // comes from how badly this update's sightings fit alone. New particles are then poses from which
  // two landmarks seen a moment ago stand where they were seen, where there are two.
  float slow_rate = 0;
  float fast_rate = 0;
  // Share of the particles that take the robot to be held up by what it walks against: they move by
  // a random part of the motion, since odometry counts steps that lead nowhere.
  float blocked_share = 0;
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
  explicit ParticleFilter(const ParticleFilterOptions& options,
                          std::vector<LandmarkPosition> landmarks);

  // Moves all samples by a motion in the body frame.
  void move(float dx_m, float dy_m, float dtheta_rad);
  // Weighs the samples by what was seen, then draws them anew.
  void observe(const std::vector<LandmarkSighting>& sightings);
  // Somebody has put the robot somewhere: this share of the samples goes to these places, in turn.
  void place(const std::vector<FieldPose>& poses, float share, float sigma_m, float sigma_rad);

  // Of all samples.
  PoseEstimate estimate() const;
  // Of the samples around the place where most of them are: where the robot is more likely than the
  // mean of two places that it may be in.
  PoseEstimate densest() const;
  const std::vector<FieldPose>& samples() const { return samples_; }

 private:
  // A landmark seen a moment ago, in the body frame of now.
  struct Remembered {
    LandmarkKind kind;
    float x_m, y_m;
    int age;  // Updates since.
  };

  static PoseEstimate estimate_of(const std::vector<FieldPose>& samples);
  void remember(const std::vector<LandmarkSighting>& sightings);
  std::vector<FieldPose> poses_from_pairs() const;
  double share_to_renew(double fit);
  FieldPose on_field(FieldPose pose) const;
  struct Fit {
    float bearing = 0, both = 0;  // Likelihoods.
  };
  Fit fit_of(const FieldPose& pose, const LandmarkSighting& sighting) const;
  const LandmarkPosition* position_of(LandmarkKind kind) const;
  void resample(const std::vector<float>& weights, const std::vector<LandmarkSighting>& sightings,
                double renewed);
  FieldPose pose_from(const LandmarkSighting& sighting);
  FieldPose turned_towards(FieldPose pose, const LandmarkSighting& sighting);
  float uniform();
  float normal();

  ParticleFilterOptions options_;
  std::vector<LandmarkPosition> landmarks_;
  std::vector<FieldPose> samples_;
  std::vector<Remembered> remembered_;
  double slow_fit_ = 0, fast_fit_ = 0;  // Running means of how well the bearings seen fit.
  uint64_t draws_ = 0;                  // Index of the next random number.
};

}  // namespace seam::sdk
