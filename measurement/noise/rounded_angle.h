// The likelihood of an angle that an encoder rounds to steps, in the form of normal errors.
#pragma once

namespace seam::measurement {

// What is logged is the multiple of `step` next to angle and noise, whose chance is the share of
// the noise between its edges. An angle inside of a step by more than the noise says nothing more.
class RoundedAngle {
 public:
  RoundedAngle(double step_rad, double noise_rad);

  // The root of twice what it costs that the logged angle is off by `miss`, with its sign.
  double z(double miss_rad) const;
  // Its derivative.
  double slope(double miss_rad) const;
  // The normal error with the density of the likeliest angle.
  double sigma_rad() const { return sigma_rad_; }
  // Of z, over all places of the angle between edges.
  double mean_square() const { return mean_square_; }

 private:
  // Of the chance of an angle that is off by so much.
  double log_chance(double miss_rad) const;

  double step_rad_, noise_rad_, most_ = 0, sigma_rad_ = 0, mean_square_ = 0;
};

}  // namespace seam::measurement
