// The text of cameras in the files of other programs, one function a program.
#pragma once

#include <string>

#include "app/exchange/exchange.h"

namespace seam::app {

std::string opencv_text(const PlainCamera& camera);  // YAML of cv::FileStorage.
std::string ros_text(const PlainCamera& camera);     // sensor_msgs/CameraInfo as YAML.
std::string mrcal_text(const PlainCamera& camera);   // A .cameramodel.
// The same, of a lens of splines; of `camera.lens` focal lengths and centre alone count.
std::string mrcal_text_of_splines(const PlainCamera& camera, const effects::ModelEffect& splines);
std::string kalibr_text(const PlainCamera& camera);  // A camchain of one camera.

}  // namespace seam::app
