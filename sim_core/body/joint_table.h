// What a behaviour has to know of a robot's joints: range, top speed, unit, and which way is
// positive; and the warning about a target beyond the range.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim_core/body/robot_body.h"

namespace seam {

// "rad", or "m" of a joint that slides.
std::string joint_unit(const RobotBody& body, size_t joint);
// Each joint's name with its unit, "pan_rad", for tables and tensors: unique, without dots.
std::vector<std::string> joint_field_names(const RobotBody& body);
// Which way the link moves when the joint's value grows.
std::string joint_direction(const RobotBody& body, size_t joint);

// "pan: 90 rad is out of its range, -1.564 to 1.564 rad, and is clamped to it; did you mean
// degrees?"; nothing for a target in the range.
std::optional<std::string> out_of_range_text(const RobotBody& body, size_t joint, double value);

// One table of all joints, as text for a terminal and as Markdown.
std::string joints_text(const RobotBody& body);
std::string joints_markdown(const RobotBody& body);

}  // namespace seam
