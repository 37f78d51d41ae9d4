#include "app/predictors/instruments.h"

#include "app/predictors/frame_predictor.h"
#include "app/predictors/range_detector.h"

namespace seam::app {

measurement::Instruments instruments() {
  return {
      .render = rendered_frames(), .detect = sdk_detectors(), .detectors = sdk_detector_names()};
}

}  // namespace seam::app
