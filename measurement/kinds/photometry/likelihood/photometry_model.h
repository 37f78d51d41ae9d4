// What a model predicts for the sums of a photometry set: mean, temporal variance and the weights
// of fixed patterns for each sample of each level.
#pragma once

#include <vector>

#include "effects/stages/sensor/sensor.h"
#include "measurement/kinds/photometry/stack/photometry_data.h"

namespace seam::measurement {

struct LevelPrediction {
  // By sample.
  std::vector<double> mean;          // DN, averaged over the pixel's fixed patterns.
  std::vector<double> variance;      // Of one value in time, DN^2; without row noise.
  std::vector<double> offset_slope;  // d mean / d offset: 1, less near clipping.
  std::vector<double> gain_slope;    // d mean / d log(signal), DN.
  std::vector<double> hot_mean;      // Mean of a hot sample; empty without hot pixels.
  std::vector<double> weak_mean;     // Mean of a weak one; likewise.
  // By frame of the level (of the chosen ones), then row * channels + channel: how far the row's
  // mean is from that of the level's other frames, DN (flicker, drifts in time).
  std::vector<std::vector<double>> row_shift;
  // Of the signal, what the scene's light makes; empty: all.
  std::vector<double> lit_part;
  double illumination = 0;  // As given, or fitted where the set leaves it blank.
  bool falls = false;       // The response does, within this light.
};

struct PhotometryPrediction {
  effects::SensorChain chain;
  std::vector<LevelPrediction> levels;  // Empty vectors where the sums have no frames.
  int nuisances = 0;
  bool moves = false;  // row_shift is not zero.
  bool falls = false;  // The response does, within the light of a level: it is none.
};

// Light on each sample relative to the set's illumination at a time (since the first frame): lens,
// uneven lighting, glare; without flicker.
std::vector<double> relative_light(const PhotometryData& data, const effects::Model& model,
                                   double t_s);
// Brightness of the lamps in each row of a frame with this exposure; 1 for steady lamps.
double lamp_row(const PhotometryData& data, int frame, int row, double exposure_s,
                const effects::Model& model);
std::vector<double> lamp_rows(const PhotometryData& data, int frame, double exposure_s,
                              const effects::Model& model);

// Light of the camera itself on each sample (effects::OwnLight); empty where there is none.
std::vector<double> own_light(const PhotometryData& data, const effects::Model& model);

// Whether gain fields or sensor maps change with time (only formulas of users can).
bool depends_on_time(const effects::Model& model);

// The sensor that an effect of its typical size alone makes.
effects::SensorChain chain_of(const effects::EffectDefinition& effect);

// The sensor before a filter over neighbours acts, where images are looked at without it: rounding
// comes after the filter, so that the inverse makes it larger, and it counts as noise of reading.
effects::SensorChain chain_before_mixing(const effects::Model& model, int file_bits);

PhotometryPrediction predict(const PhotometryData& data, const PhotometrySums& sums,
                             const effects::Model& model, double set_noise_dn);

}  // namespace seam::measurement
