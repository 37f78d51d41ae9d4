// What some kinds of measurement need beyond the effects: a renderer, detectors, whole runs. They
// come in as arguments, from whoever puts the program together (app/), so that measurement/ knows
// none of them.
#pragma once

#include <string>
#include <vector>

#include "measurement/imaging/frame_predictor.h"
#include "measurement/imaging/range_detector.h"
#include "measurement/imaging/run_maker.h"

namespace seam::measurement {

// Parts may be missing: sets that need them are then refused with the reason.
struct Instruments {
  OpenFrameRenderer render;
  MakeRangeDetector detect;
  std::vector<std::string> detectors;  // The behaviours that `detect` knows.
  OpenRuns runs;
};

}  // namespace seam::measurement
