#include "app/logs/joint_names.h"

#include <fmt/format.h>

#include "sim_core/base/error.h"
#include "sim_core/scenario/scenario.h"

namespace seam::app {

JointNames::JointNames(const scheduler::RunHeader& header) {
  try {
    const Scenario scenario = Scenario::from_text(header.scenario_text, header.scenario_name);
    for (const RobotSpec& robot : scenario.robots) {
      std::vector<std::string>& names = names_.emplace_back();
      for (size_t j = 0; j < robot.body.joint_count(); ++j)
        names.push_back(robot.body.joint_name(j));
    }
  } catch (const InputError&) {
    names_.clear();
  }
}

std::string JointNames::of(size_t robot, int joint) const {
  const auto place = static_cast<size_t>(joint);
  if (robot < names_.size() && place < names_[robot].size()) return names_[robot][place];
  return fmt::format("joint {}", joint);
}

bool JointNames::lacks_head(size_t robot) const {
  return robot < names_.size() && (names_[robot].empty() || names_[robot][0] != kJointNames[kTilt]);
}

}  // namespace seam::app
