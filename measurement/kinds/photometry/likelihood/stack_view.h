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
};

}  // namespace seam::measurement
