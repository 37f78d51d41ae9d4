// `seam joints FILE...`: what a behaviour has to know of the joints of robots.
#include <cstdio>
#include <set>

#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/body/joint_table.h"
#include "sim_core/scenario/scenario.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

constexpr const char* kPageHead =
    "# Joints of the robots\n"
    "\n"
    "Made by `seam joints models/robot_ers210.yaml scenarios/arm/arm.yaml --markdown`; a test "
    "compares "
    "this page with the\n"
    "program. Run it with a scenario of yours for its robots.\n"
    "\n"
    "Angles are in rad, lengths in m. A target beyond the range is clamped to it, with a warning "
    "for "
    "each joint. A target moves the\n"
    "joint at its top speed where the command gives no lower one.\n";

// The bodies of a robot file, or of a scenario's robots, each kind once.
std::vector<RobotBody> bodies_in(const std::string& path) {
  const ConfigNode root = ConfigNode::from_file(path);
  const std::string format = root.at("format").text();
  if (format == "seam-robot/1") {
    RobotBody body;
    read_config(root, [&](ConfigTable& table) { describe(table, body); });
    return {body};
  }
  if (format != "seam-scenario/1")
    root.at("format").fail(fmt::format(
        "found '{}', expected seam-robot/1 or seam-scenario/1: a file that has robots", format));
  std::vector<RobotBody> bodies;
  std::set<std::string> shown_tables;
  for (const RobotSpec& robot : Scenario::from_file(path).robots)
    if (shown_tables.insert(robot.body.name + joints_text(robot.body)).second)
      bodies.push_back(robot.body);
  return bodies;
}

}  // namespace

void add_joints(app::Command app) {
  app::Command command = app.add_subcommand(
      "joints", "Range, unit, top speed and positive direction of each joint of a robot");
  auto files = std::make_shared<std::vector<std::string>>();
  auto markdown = std::make_shared<bool>(false);
  command.add_option("FILE", *files, "A scenario, for its robots, or a robot file (seam-robot/1)")
      .required();
  command.add_flag("--markdown", *markdown, "As a page (docs/reference/joints.md)");
  command.footer("Example: seam joints models/robot_ers210.yaml");
  command.callback([files, markdown] {
    if (*markdown) std::fputs(kPageHead, stdout);
    for (const std::string& file : *files)
      for (const RobotBody& body : bodies_in(file))
        std::fputs((*markdown ? fmt::format("\n## {}\n\n{}", body.name, joints_markdown(body))
                              : joints_text(body))
                       .c_str(),
                   stdout);
  });
}

}  // namespace seam::tools
