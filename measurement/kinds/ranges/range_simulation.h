// The simulator as a set of kind `ranges` runs it: the scene with its ball at each place, rendered,
// given the sensor's noise, and measured by the behaviour's own detector.
#pragma once

#include <memory>
#include <vector>

#include "effects/stages/sensor/sensor.h"
#include "measurement/imaging/frame_predictor.h"
#include "measurement/imaging/instruments.h"
#include "measurement/imaging/light_store.h"
#include "measurement/imaging/range_detector.h"
#include "measurement/kinds/ranges/ranges_data.h"
#include "sim_core/scene/scene.h"

namespace seam::measurement {

// What the detector would report at one place, over the noise of single frames.
struct RangePrediction {
  int trials = 0;
  int seen = 0;  // In so many of them it saw the ball.
  double mean_m = 0;
  double variance_m2 = 0;      // Of a single measurement.
  double fourth_m4 = 0;        // Fourth central moment.
  double own_variance_m2 = 0;  // Of the mean: from the finite number of trials.
  double pattern_variance_m2 =
      0;  // Of the mean: from the sensor's fixed pattern, which all frames share.
};

// Variance of a sample standard deviation of n values with this variance and fourth moment.
double variance_of_spread(double variance, double fourth, double n);

class RangeSimulation {
 public:
  RangeSimulation(const MeasurementSet& set, const std::vector<BallPlace>& places,
                  const Instruments& instruments);

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

  // From now on only what lies about where this model sees the ball is looked at: all else has the
  // colours that this model gives it without noise.
  void look_about(const Model& model);

  // `dither_px` above 0: the mean over images displaced by about so much, in which the detector's
  // jumps from pixel to pixel are smoothed. The same random numbers for every model. Throws
  // InputError for a model without an image.
  std::vector<RangePrediction> predict(const Model& model, const std::vector<size_t>& places,
                                       double dither_px = 0) const;

  // By place: how much a measurement without noise, and the spread of those with it, scatter under
  // displacements of the image.
  struct Scatter {
    double mean_m2 = 0, spread_m2 = 0;
  };
  std::vector<Scatter> scatter(const Model& model, double dither_px) const;

  // One measurement with the noise of one frame; nothing where no ball is seen. `noise` false: the
  // noise-free frame.
  std::optional<RangeSighting> measure_once(const Model& model, size_t place,
                                            const effects::FixedPattern& pattern,
                                            RandomStream frame_noise, bool noise) const;

 private:
  // What trials at one place share.
  struct Trials {
    const Model& model;
    const effects::SensorChain& chain;
    effects::SensorExposure exposure;
    size_t place = 0;
    Gaze gaze;
    PixelWindow window;
    const std::vector<uint8_t> surroundings;
    bool patterns = false;  // A fixed pattern of its own for each trial.
  };
  Trials trials_of(const Model& model, const effects::SensorChain& chain, size_t place) const;
  std::vector<uint8_t> surroundings(const Model& model, size_t place) const;
  std::vector<LightImage> render(const Model& model, const std::vector<size_t>& places) const;
  std::vector<double> trial_values(const Trials& trials, const std::vector<float>& light,
                                   double shift_u, double shift_v, int first, int count) const;

  MakeFramePredictor make_predictor_;
  int width_px_, height_px_;
  std::vector<BallPlace> places_;
  std::unique_ptr<RangeDetector> detector_;
  Rgb background_;
  Lighting lighting_;
  std::vector<Primitive> primitives_;
  size_t ball_ = 0;                                 // Among the primitives.
  std::vector<PixelWindow> windows_;                // By place; empty: the whole frame.
  std::vector<std::vector<uint8_t>> surroundings_;  // By place, with windows.
  std::unique_ptr<LightStore> store_;
};

}  // namespace seam::measurement
