// The instruments of this program: its own renderer and the SDK's detectors.
#pragma once

#include "measurement/imaging/instruments.h"

namespace seam::app {

measurement::Instruments instruments();

}  // namespace seam::app
