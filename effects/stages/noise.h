// Errors of measurements beyond independent normal ones: those that wander in time, those that
// last, those that are few and large, those that grow with the motion. Each kind of measurement
// takes its own from what the effects of a model add up to.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "effects/model.h"
#include "sim_core/base/maths.h"

namespace seam::effects {

// An Ornstein-Uhlenbeck process: covariance sigma^2 exp(-lag / tau_s). With tau_s 0 it is white.
struct Wander {
  double sigma = 0;
  double tau_s = 0;

  double covariance(double lag_s) const {
    if (lag_s == 0) return sigma * sigma;
    return tau_s > 0 ? sigma * sigma * maths::exp(-lag_s / tau_s) : 0;
  }
};

// A share of the errors has something more.
struct Few {
  double fraction = 0;
  double size = 0;  // Scale of an exponential, or sigma.

  bool none() const { return !(fraction > 0 && size > 0); }
};

// Grows with the body's motion: sigma * (1 + per_mps * speed + per_radps * turn).
struct MovingNoise {
  double xy_sigma_m = 0, theta_sigma_rad = 0;
  double per_mps = 0, per_radps = 0;

  double growth(double mps, double radps) const {
    return 1 + per_mps * std::abs(mps) + per_radps * std::abs(radps);
  }
};

// What is wrong with a gyroscope or an accelerometer (stages/inertial/inertial.h).
inline constexpr double kNever = std::numeric_limits<double>::infinity();
using Triad = std::array<double, 3>;  // By axis.

// A line in the readings: a sine whose amplitude and phase wander (stages/inertial/vibration.h).
struct Vibration {
  Triad rms{};
  double frequency_hz = 0;
  double width_hz = 0;  // Of its power, at half of the height.
  double skew = 0;
};

struct InertialSensor {
  Triad bias{};                  // At kBiasAt_c.
  Triad per_k{};                 // Change of the bias a kelvin.
  Triad scale{};                 // Relative error.
  std::array<Triad, 3> cross{};  // What an axis (the first) has of the others; no diagonal.
  double most = kNever;          // The end of its range.
  Triad white{};                 // Density of white noise, unit / sqrt(Hz): N.
  Triad flicker{};   // Bias instability, unit: B; the flat of the Allan deviation is 0.664 of it.
  Triad walk{};      // Density of a random walk of the bias, unit / s / sqrt(Hz): K.
  Triad rounding{};  // Rounding of what the sensor adds up before it reports it, unit * s: Q.
  std::vector<Vibration> vibrations;
};

// Biases are those at this temperature.
inline constexpr double kBiasAt_c = 25;

struct Inertial {
  InertialSensor gyro, accel;
  Triad gyro_per_force{};    // Of a gyroscope's axis by the force along it, (rad/s) / (m/s^2).
  double clock_ppm = 0;      // How much faster its clock runs than the one that stamps its samples,
  double stamp_sigma_s = 0;  // and by how much the stamps scatter.
  // A camera on the same body: the sensor's time is the camera's plus this, and plus so much of the
  // exposure. Its axes are the sensor's turned by a vector.
  double camera_offset_s = 0, camera_offset_of_exposure = 0;
  Triad camera_turn_rad{};
};

struct Noise {
  // Of one landmark in one run.
  std::vector<Wander> range, bearing;
  double range_bias_variance = 0, bearing_bias_variance = 0;
  double delay_variance = 0;    // Of all ranges of a landmark, in all runs.
  double place_variance = 0;    // Of each landmark's x and of its y in the map, in all runs.
  std::vector<Wander> heading;  // Shared by all bearings of a run.
  std::vector<Wander> joint;    // Of a logged joint.
  double command_sigma_s = 0;   // Of the time at which each of its commands acts.
  Few range_tail;               // Ranges that are too long by an exponential.
  Few point_scatter;            // Points with a further normal error.
  std::vector<MovingNoise> pose;
  Inertial inertial;  // All that is wrong with a gyroscope and an accelerometer.

  bool hangs_together() const {
    return !range.empty() || !bearing.empty() || !heading.empty() || !joint.empty() ||
           range_bias_variance > 0 || bearing_bias_variance > 0 || delay_variance > 0 ||
           place_variance > 0;
  }
};

inline Noise noise_of(const Model& model) {
  Noise noise;
  for (const ModelEffect& effect : model.effects()) {
    if (effect.definition->noise) effect.definition->noise(effect.values(), noise);
  }
  return noise;
}

}  // namespace seam::effects
