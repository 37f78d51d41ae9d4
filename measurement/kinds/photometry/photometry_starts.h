// Where fits of photometry candidates start: estimates from the residual means and variances.
#pragma once

#include <vector>

#include "measurement/kinds/photometry/likelihood/photometry_cells.h"
#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"

namespace seam::measurement {

struct PhotometryView {
  const PhotometryData& data;
  const PhotometrySums& sums;
  double set_noise_dn = 0;
  bool channels_share = true;
  const CellStore* cells = nullptr;  // Nothing: every sample is evaluated.
};

double log_likelihood(const PhotometryView& view, const Model& model);

// Values of the effect's parameters from which fits start, the likeliest first.
std::vector<std::vector<double>> photometry_starts(const PhotometryView& view, const Model& model,
                                                   const EffectDefinition& effect);

// How many frequencies `flicker_starts` can tell apart.
double flicker_looks(const PhotometryData& data, const Model& model);
// The strongest periodic wave of the residual light: frequencies to start from
// (photometry_flicker.cc).
std::vector<std::vector<double>> flicker_starts(const PhotometryView& view, const Model& model,
                                                const PhotometryPrediction& prediction);

}  // namespace seam::measurement
