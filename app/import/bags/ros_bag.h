// Bags of ROS: MCAP files with CDR (ROS 2), and bags of version 2.0 (ROS 1). One chunk at a time is
// in memory.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/import/bags/ros_message.h"
#include "app/import/files/budget.h"
#include "mcap/io.h"

namespace seam::app {

struct BagTopic {
  std::string name;
  std::string type;  // "sensor_msgs/JointState", in either ROS.
  uint64_t messages = 0;
  std::string definition;  // The text of the type's; empty: the bag has none that is understood.
};

// Calls `visit` for each message in the order of the file, with the place of its topic in `topics`,
// which grows as they appear, and the time at which it was recorded.
using BagVisit =
    std::function<void(size_t topic, int64_t log_ns, std::string_view bytes, RosForm form)>;

// Reads the whole file; a folder's bag is that in it. Returns sentences about what could not be
// read. Throws InputError where it is no bag, or holds nothing.
std::vector<std::string> read_bag(const std::filesystem::path& path, std::vector<BagTopic>& topics,
                                  const BagVisit& visit);
// The same of a file that is open already, of version 2.0 (ROS 1). Its compressed chunks take from
// the budget of the whole bag.
std::vector<std::string> read_ros1_bag(const mcap::Input& input, std::vector<BagTopic>& topics,
                                       const BagVisit& visit, UnpackBudget& budget);

}  // namespace seam::app
