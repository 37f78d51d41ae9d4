// The noise of one axis of an inertial sensor, sample by sample, with the power over frequency that
// inertial.h states: the simulator's sensors read so. Measured sets are drawn over frequency.
#pragma once

#include <span>
#include <vector>

#include "effects/stages/noise.h"
#include "sim_core/base/random.h"

namespace seam::effects {

class NoiseSeries {
 public:
  // Samples `dt_s` apart.
  NoiseSeries(const InertialSensor& sensor, size_t axis, double dt_s, RandomStream stream);

  // How many numbers last from one sample to the next; all are 0 before the first one.
  size_t state_size() const;
  // The next sample, whose value with all errors of the mean is `mean`. Each `index` has its draws.
  double reading(double mean, uint64_t index, std::span<double> state) const;

 private:
  // An oscillator that white noise drives: its deflection and its rate, each of unit variance.
  struct Swing {
    double rms = 0, deflection = 0, rate = 0;  // Shares of both in what is read.
    double kept[2][2] = {};                    // Of both, from sample to sample;
    double renewed[3] = {};                    // a triangular root of the rest.
  };
  static Swing swing_of(const Vibration& line, size_t axis, double dt_s);

  double dt_s_, white_, step_;  // Of a sample: white noise, a step of the walk.
  double rounded_to_;           // What is added up.
  double wander_sigma_;         // Of each wandering part.
  std::vector<double> keeps_;   // What such a part keeps from sample to sample.
  std::vector<Swing> swings_;
  RandomStream stream_;
};

}  // namespace seam::effects
