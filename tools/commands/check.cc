// `seam check FILE`: validates any file of ours, by its `format:` line.
#include <cstdio>

#include "effects/model.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/scenario/scenario.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

// The camera models inside are for effects/ to check.
void check_scenario(const std::string& file) {
  const Scenario scenario = Scenario::from_file(file);
  for (const RobotSpec& robot : scenario.robots) {
    const CameraSpec& camera = robot.camera;
    if (!camera.model_yaml.empty()) {
      effects::Model::from_config(ConfigNode::from_text(camera.model_yaml, camera.model_name));
    }
  }
}

}  // namespace

void add_check(app::Command app) {
  app::Command command =
      app.add_subcommand("check", "Validates a scenario, model, scene or measurement set");
  auto file = std::make_shared<std::string>();
  command.add_option("FILE", *file, "The file").required();
  command.footer("Example: seam check scenarios/head_swing.yaml");
  command.callback([file] {
    const ConfigNode root = ConfigNode::from_file(*file);
    const std::string format = root.at("format").text();
    if (format == "seam-model/1") {
      effects::Model::from_config(root);
    } else if (format == "seam-scenario/1") {
      check_scenario(*file);
    } else {
      root.at("format").fail(suggestion_for(format, {"seam-model/1", "seam-scenario/1"}));
    }
    std::printf("%s: a valid %s\n", file->c_str(), format.c_str());
  });
}

}  // namespace seam::tools
