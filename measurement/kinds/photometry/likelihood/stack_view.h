// Images, their sums over some of the frames, and how they are evaluated.
#pragma once

#include "measurement/kinds/photometry/likelihood/photometry_cells.h"
#include "measurement/kinds/photometry/likelihood/photometry_likelihood.h"

namespace seam::measurement {

struct PhotometryView {
  const PhotometryData& data;
  const PhotometrySums& sums;
  double set_noise_dn = 0;
  bool channels_share = true;
  const CellStore* cells = nullptr;  // Nothing: every sample is evaluated.
  const Model* near = nullptr;       // As in CellStore.
  // Where a filter over neighbours was undone in the images: log_mixing of it (mixing.h).
  double log_mixing = 0;
};

}  // namespace seam::measurement
