#include "app/simulator.h"

#include <algorithm>
#include <map>

#include "app/data_file.h"
#include "app/scene_assets.h"
#include "app/trust/tokens.h"
#include "effects/cameras.h"
#include "effects/questions.h"
#include "effects/stages/robots/robot_parts.h"
#include "scheduler/log/log_records.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"

namespace seam::app {

namespace {

// A robot without a model has an ideal camera with the ERS-210's field of view (57.6 degrees).
std::string ideal_model_yaml(const CameraSpec& camera) {
  const double focal_px = 161.9 * static_cast<double>(camera.width_px) / 178;
  return fmt::format(
      "format: seam-model/1\nname: ideal\neffects:\n"
      "  pinhole: {{fx_px: {}, fy_px: {}, cx_px: {}, cy_px: {}}}\n",
      focal_px, focal_px, 0.5 * static_cast<double>(camera.width_px - 1),
      0.5 * static_cast<double>(camera.height_px - 1));
}

effects::Model model_of(const RobotSpec& robot) {
  const bool given = !robot.camera.model_yaml.empty();
  const effects::Model model = effects::Model::from_config(
      ConfigNode::from_text(given ? robot.camera.model_yaml : ideal_model_yaml(robot.camera),
                            given ? robot.camera.model_name : "ideal model of " + robot.id));
  for (const effects::ModelEffect& effect : model.effects()) {
    if (!effect.definition->scenario) continue;
    throw InputError(
        fmt::format("model '{}': effect '{}' changes the scenario, which a robot's model cannot: "
                    "set its keys in the scenario, or with --set",
                    model.name(), effect.definition->name));
  }
  // An individual belongs to the robot's id, whatever the seed of the run.
  const effects::Model own = model.individual(RandomStream{}.child("individual").child(robot.id));
  effects::check_pictured(own);
  return effects::without_points_own(own);
}

void replace_models(Scenario& scenario, const std::vector<std::string>& models) {
  for (const std::string& option : models) {
    const size_t equals = option.find('=');
    const std::string robot = equals == std::string::npos ? "" : option.substr(0, equals);
    const std::string file = equals == std::string::npos ? option : option.substr(equals + 1);
    const std::string yaml = read_file(file, 16 << 20);
    bool found = robot.empty();
    for (RobotSpec& spec : scenario.robots) {
      if (!robot.empty() && spec.id != robot) continue;
      found = true;
      spec.camera.model_yaml = yaml;
      spec.camera.model_name = file;
    }
    if (!found) {
      std::vector<std::string> ids;
      for (const RobotSpec& spec : scenario.robots) ids.push_back(spec.id);
      throw UsageError(fmt::format("--model {}: unknown robot '{}'{}", option, robot,
                                   suggestion_for(robot, ids)));
    }
  }
}

// What the options change, as paths and values.
std::vector<ScenarioChange> changes_of(const SimulatorOptions& options) {
  std::vector<ScenarioChange> changes;
  for (const std::string& text : options.changes) changes.push_back(change_from_text(text));
  if (options.seed) changes.push_back({"seed", {fmt::format("{}", *options.seed)}});
  for (const std::string& option : options.models) {
    const size_t equals = option.find('=');
    const bool all = equals == std::string::npos;
    changes.push_back({fmt::format("robots[{}].camera.model", all ? "*" : option.substr(0, equals)),
                       {all ? option : option.substr(equals + 1)}});
  }
  return changes;
}

effects::ModelParts::JointModels joint_models_of(const Scenario& scenario) {
  effects::ModelParts::JointModels models;
  for (const RobotSpec& robot : scenario.robots) {
    for (const JointServo& servo : robot.servos) {
      const effects::Model model =
          effects::Model::from_config(ConfigNode::from_text(servo.model_yaml, servo.model_name));
      const RandomStream own = RandomStream{}.child("individual").child(robot.id);
      models.insert_or_assign({robot.id, servo.joint}, model.individual(own.child(servo.joint)));
    }
  }
  return models;
}

constexpr const char *kRendererVersion = "renderer", *kGlSource = "opengl_from";

}  // namespace

std::vector<effects::Model> models_of(const Scenario& scenario) {
  std::vector<effects::Model> models;
  for (const RobotSpec& robot : scenario.robots) models.push_back(model_of(robot));
  return models;
}

Scenario load_scenario(const std::filesystem::path& file, const SimulatorOptions& options) {
  Scenario scenario = without_fingerprints(Scenario::from_file(given_or_ours(file)));
  std::vector<ScenarioChange> changes;
  for (const std::string& text : options.changes) changes.push_back(change_from_text(text));
  scenario = changed_scenario(scenario, changes, ".");
  if (options.seed) scenario.seed = *options.seed;
  replace_models(scenario, options.models);
  return scenario;
}

Simulator make_simulator(Scenario scenario, const SimulatorOptions& options) {
  std::unique_ptr<render::GlDevice> opengl = device_for(scenario, options.drawing, options.gl);
  std::vector<effects::Model> models = models_of(scenario);
  std::map<std::string, effects::Model> by_robot;
  for (size_t i = 0; i < models.size(); ++i) by_robot.emplace(scenario.robots[i].id, models[i]);
  World world(scenario, effects::ModelParts(std::move(by_robot), joint_models_of(scenario)));
  scheduler::RunHeader header;
  header.scenario_text = with_fingerprints(scenario).to_yaml();
  header.scenario_name = scenario.name;
  header.seed = static_cast<uint64_t>(scenario.seed);
  header.versions = {{"seam", SEAM_VERSION},
                     {"log", std::string(scheduler::kLogFormat)},
                     {"state", std::string(scheduler::kStateVersion)},
                     {scheduler::kEventsKey, scheduler::kEventsVersion},
                     {kRendererVersion, opengl ? "opengl" : "analytic"}};
  if (opengl) {
    header.versions.emplace_back(kGlSource, opengl->source());
    header.versions.emplace_back("opengl", opengl->version());
    header.versions.emplace_back("opengl_renderer", opengl->renderer());
  }
  auto renderer = std::make_unique<CameraRenderer>(scenario, models, options.render_workers,
                                                   options.rendering, std::move(opengl));
  if (!options.cameras_when_used) renderer->make_cameras();
  for (const RobotSpec& robot : scenario.robots) header.robots.push_back(robot.id);
  header.sections = world.section_names();
  return {std::move(scenario), std::move(models), std::move(world),
          std::move(renderer), std::move(header), changes_of(options)};
}

Simulator make_simulator(const scheduler::RunHeader& header, const SimulatorOptions& options) {
  Scenario scenario = Scenario::from_made_text(header.scenario_text, header.scenario_name);
  scenario.seed = static_cast<int64_t>(header.seed);
  replace_models(scenario, options.models);
  SimulatorOptions as_recorded = options;
  for (const auto& [name, version] : header.versions) {
    if (name == kRendererVersion && options.drawing == "auto") as_recorded.drawing = version;
    // Where it is not here another draws, and replays say that pixels may differ.
    if (name == kGlSource && options.gl == "auto" && render::opengl_is_here(version))
      as_recorded.gl = version;
  }
  Simulator simulator = make_simulator(without_fingerprints(scenario), as_recorded);
  simulator.header.scenario_text = with_fingerprints(std::move(scenario)).to_yaml();
  const auto is_events = [](const auto& version) { return version.first == scheduler::kEventsKey; };
  if (std::none_of(header.versions.begin(), header.versions.end(), is_events))
    std::erase_if(simulator.header.versions, is_events);
  return simulator;
}

}  // namespace seam::app
