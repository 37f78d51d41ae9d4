// Readings of inertial sensors in bags of ROS: messages of type sensor_msgs/Imu.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "app/import/draft/request.h"
#include "app/import/draft/set_draft.h"

namespace seam::app {

// By the stamps of the messages' headers; axes of the gyroscope in rad/s, then of the
// accelerometer in m/s^2. Empty: the driver says that it has no such sensor.
struct ImuBag {
  std::string topic;
  std::vector<int64_t> ns;
  std::array<std::vector<double>, 6> values;
};

bool is_ros_bag(const std::filesystem::path& source);
// The topic that the map names as `imu`, else the only one. The draft hears of what could not be
// read. Throws InputError.
ImuBag read_imu_bag(const std::filesystem::path& bag, const ImportRequest& request,
                    SetDraft& draft);

}  // namespace seam::app
