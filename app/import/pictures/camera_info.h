// The calibration that a bag of ROS brings along.
#pragma once

#include <optional>
#include <string>

#include "app/import/bags/ros_message.h"
#include "app/import/draft/calibration.h"

namespace seam::app {

// A CameraInfo; nothing where the camera is not calibrated. `rectified`: of the pictures that were
// made of the camera's, which have no distortion. Throws InputError, naming the topic.
std::optional<PlainCamera> read_camera_info(RosMessage& message, const std::string& topic,
                                            bool rectified, SetDraft& draft);

}  // namespace seam::app
