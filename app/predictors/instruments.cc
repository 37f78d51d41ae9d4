#include "app/predictors/instruments.h"

#include "app/predictors/frame_predictor.h"
#include "app/predictors/range_detector.h"

namespace seam::app {

measurement::Instruments instruments(const OutcomeRunsOptions& runs) {
  return {.render = rendered_frames(),
          .detect = sdk_detectors(),
          .detectors = sdk_detector_names(),
          .runs = outcome_runs(runs)};
}

}  // namespace seam::app
