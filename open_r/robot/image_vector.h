// Camera frames as OPEN-R's images: three sizes, and the colours that the table detects.
#pragma once

#include <OPENR/ODataFormats.h>
#include <OPENR/RCRegion.h>

#include <array>

#include "open_r/robot/camera_settings.h"
#include "robot_sdk/robot.h"

namespace seam::open_r {

// The colour detection table of the camera: by channel and range of Y.
using ColourTable = std::array<std::array<longword, ocdtMAX_Y_SEGMENT>, ocdtNUM_CHANNELS>;

// Of a picture of 178 columns the middle 176 count. `counter` numbers images. The region has one
// reference, the caller's.
RCRegion* make_image_vector(const sdk::Frame& frame, const CameraSettings& settings,
                            const ColourTable& table, OPrimitiveID camera, longword frame_number,
                            word counter);

// The frame of 8 ms whose sensors belong to the image: that nearest to its middle row's exposure.
longword frame_number_of(const sdk::Frame& frame);

}  // namespace seam::open_r
