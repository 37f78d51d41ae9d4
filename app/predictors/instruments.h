// The instruments of this program: its own renderer, the SDK's detectors, and whole runs.
#pragma once

#include "app/predictors/outcome_runs.h"
#include "measurement/imaging/instruments.h"

namespace seam::app {

measurement::Instruments instruments(const OutcomeRunsOptions& runs = {});

}  // namespace seam::app
