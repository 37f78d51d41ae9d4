// Messages of any type by the text of their definition, which bags hold: "ros2msg" in MCAP files,
// and that of a connection in bags of ROS 1 (docs.ros.org, "Interfaces"). For types that come in
// several versions, or that we do not know.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "app/import/bags/ros_message.h"

namespace seam::app {

// Without what ROS 2 adds: "sensor_msgs/msg/JointState" is "sensor_msgs/JointState".
std::string plain_ros_type(const std::string& type);

class RosDefinition {
 public:
  // `type`: "control_msgs/JointTrajectoryControllerState". Throws InputError where the text is no
  // definition of it, or has more fields than a message should.
  RosDefinition(const std::string& type, std::string_view text);

  struct Field {
    std::string path;  // "reference.positions"; of a list's elements the same as of one.
    bool is_text = false;
    bool is_real = false;  // float32 or float64.
  };
  // The fields that hold a number or a text, or lists of them, in the order of the message.
  const std::vector<Field>& fields() const { return fields_; }
  // The place of a field, -1 where there is none.
  int find(const std::string& path) const;

  // By field: its values, of all elements of the lists that it stands in. Times count in seconds.
  struct Values {
    std::vector<std::vector<double>> numbers;
    std::vector<std::vector<std::string>> texts;
    int64_t stamp_ns = 0;  // Of header.stamp; 0: none.
    size_t elements = 0;   // Of all lists, for the limit on them.
  };
  Values read(std::string_view bytes, RosForm form, const std::string& name) const;

 private:
  enum class Kind { boolean, natural, whole, real, text, time, message };
  enum class List { none, fixed, counted };
  struct Node {
    Kind kind = Kind::message;
    size_t bytes = 0;  // Of a number.
    List list = List::none;
    uint32_t count = 0;  // Of a fixed list.
    size_t field = 0;    // Of a leaf.
    bool is_stamp = false;
    std::vector<Node> members;
  };
  class Parser;

  void read_node(const Node& node, RosMessage& message, Values& values) const;
  void read_one(const Node& node, RosMessage& message, Values& values) const;

  std::string type_;
  std::vector<Field> fields_;
  Node root_;
};

}  // namespace seam::app
