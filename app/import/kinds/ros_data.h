// What is understood of a bag of ROS, by its topics.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/import/bags/controller_state.h"
#include "app/import/bags/joint_names.h"
#include "app/import/bags/ros_bag.h"
#include "app/import/draft/set_draft.h"
#include "app/import/draft/walk_draft.h"
#include "app/import/kinds/ros_transforms.h"
#include "app/import/pictures/camera_info.h"

namespace seam::app {

struct JointSampleRow {
  int64_t log_ns = 0, stamp_ns = 0;
  SharedNames names;  // None of a message without names.
  std::vector<double> positions;
  std::vector<double> efforts = {};  // Often none, or not finite.
};

// All that is understood of a bag, by the place of its topic.
struct BagData {
  std::vector<BagTopic> topics;
  std::map<size_t, std::vector<JointSampleRow>> joints;
  // Of controllers with command and state in one message.
  struct ControllerRows {
    ControllerState state;
    std::vector<ControllerState::Sample> rows;
    size_t without = 0;  // Messages that hold no command beside a state.
  };
  std::map<size_t, ControllerRows> controllers;
  std::map<size_t, std::vector<PoseRow>> odometry, poses;
  std::map<size_t, std::string> frames;                   // In which poses of a topic are.
  std::map<size_t, std::vector<VelocityCommand>> twists;  // By the time of recording.
  std::map<size_t, PlainCamera> cameras;
  RosTransforms transforms;
};

// Reads a bag; the draft hears of what could not be read. Throws InputError.
BagData read_bag_data(const std::filesystem::path& bag, SetDraft& draft);

}  // namespace seam::app
