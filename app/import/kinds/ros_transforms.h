// Transforms of ROS (TF) as the poses of one frame in another.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/import/bags/ros_message.h"
#include "app/import/draft/walk_draft.h"

namespace seam::app {

struct PoseRow {
  int64_t log_ns = 0;
  StampedPose pose;
};

// The pose that comes next in a message. Throws InputError where it is none.
StampedPose pose_in(RosMessage& message, int64_t stamp_ns, const std::string& topic);

class RosTransforms {
 public:
  // A TFMessage, or a TransformStamped alone.
  void take(RosMessage& message, int64_t log_ns, const std::string& topic);
  void take_one(RosMessage& message, int64_t log_ns, const std::string& topic);

  bool empty() const { return frames_.empty(); }
  // Frames that move in others, as PARENT:CHILD.
  std::vector<std::string> moving() const;
  // The body that goes about in the frame that all stand in: its name, PARENT:CHILD. Empty where
  // the names do not say it.
  std::string body() const;
  // The poses of CHILD in PARENT at the times of CHILD's own transforms; those between are as they
  // were last sent. Nothing where no way leads from CHILD up to PARENT.
  std::optional<std::vector<PoseRow>> poses(const std::string& parent_and_child) const;

 private:
  struct Frame {
    std::string parent;
    std::vector<PoseRow> rows;  // Its poses in the parent.
  };
  static bool moves(const Frame& frame);

  std::map<std::string, Frame> frames_;  // By the child's name.
};

}  // namespace seam::app
