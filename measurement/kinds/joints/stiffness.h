// Controllers of several gains in a log that does not tell them: how much stiffer one run is than
// another, by the accelerations that errors of the angle give, without a model of the motor.
#pragma once

#include <string>
#include <vector>

#include "measurement/kinds/joints/joints.h"

namespace seam::measurement {

// By log: the gain of its controller over that of the log with the median one. All 1 where one gain
// explains the accelerations about as well, or nothing tells.
std::vector<double> stiffness_of(const JointLogs& set, double noise_rad);

// A sentence for logs of one gain, or none told, whose runs differ; empty where they do not.
std::string note_of_stiffness(const CsvTable& table, const JointLogs& set, double noise_rad);

// A sentence for joints that move unlike each other: a model moves all alike. Empty where they do
// not, or nothing tells.
std::string note_of_unlike_joints(const CsvTable& table, const JointLogs& set, double noise_rad);

}  // namespace seam::measurement
