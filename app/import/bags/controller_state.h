// The state of a controller in one message: the commanded and the measured angle of each
// joint (control_msgs/JointTrajectoryControllerState and its successors, JointControllerState,
// MultiDOFStateStamped, and others that name such fields).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/import/bags/joint_names.h"
#include "app/import/bags/ros_bag.h"
#include "app/import/bags/ros_definition.h"

namespace seam::app {

class ControllerState {
 public:
  // Nothing where the topic's type has no pair of fields for command and state. Throws InputError
  // where its definition does not hold.
  static std::optional<ControllerState> of(const BagTopic& topic);

  // Whether the type is known as a controller's state, not only alike by its fields.
  bool is_known() const { return known_; }
  // The fields that were read last: "reference.positions and feedback.positions".
  std::string fields_text() const;

  struct Sample {
    int64_t ns = 0;  // The message's stamp, or the time of recording where it has none.
    SharedNames names;
    std::vector<double> command, measured;  // By joint.
  };
  // Nothing where the message holds no command beside a state, as before the first trajectory.
  std::optional<Sample> read(std::string_view bytes, RosForm form, int64_t log_ns);

 private:
  struct Pair {
    size_t command = 0, measured = 0;
    int names = -1;
  };
  ControllerState(const BagTopic& topic, RosDefinition definition)
      : topic_(topic.name), definition_(std::move(definition)) {}
  void find_pairs();
  int names_near(const std::string& prefix) const;
  std::vector<std::string> names_of(const RosDefinition::Values& values, const Pair& pair) const;

  std::string topic_;
  RosDefinition definition_;
  bool known_ = false;
  std::vector<Pair> pairs_;  // The preferred one first.
  size_t last_ = 0;
  SharedNames last_names_;
};

}  // namespace seam::app
