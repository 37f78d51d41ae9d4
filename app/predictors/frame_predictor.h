// The renderer as measurement sets of whole images need it.
#pragma once

#include "measurement/imaging/frame_predictor.h"

namespace seam::app {

measurement::MakeFramePredictor rendered_frames();

}  // namespace seam::app
