// `seam check PATH`: validates any file or folder of ours and says what it holds.
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "app/import/recognise.h"
#include "app/predictors/instruments.h"
#include "app/scene_assets.h"
#include "app/session/behaviours.h"
#include "app/simulator.h"
#include "app/sweep/table.h"
#include "effects/cameras.h"
#include "effects/catalogue_help.h"
#include "effects/formulas/formula_ranges.h"
#include "effects/model.h"
#include "effects/questions.h"
#include "effects/stages/lens_domain.h"
#include "mcap/reader.h"
#include "measurement/check/describe.h"
#include "render/colour/colour_table.h"
#include "scheduler/log/log.h"
#include "sim_core/base/config.h"
#include "sim_core/base/error.h"
#include "sim_core/input/config_table.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/scenario/scenario.h"
#include "sim_core/scene/scene_file.h"
#include "tools/command.h"
#include "tools/commands/analysis.h"

namespace seam::tools {
namespace {

namespace fs = std::filesystem;

struct CheckSettings {
  std::string path;
  std::string model;
};

std::string effects_text(const effects::Model& model) {
  std::string text;
  for (const effects::ModelEffect& effect : model.effects()) {
    text += fmt::format("  {:<12} ", effect.definition->name);
    const size_t count = effect.parameters.size();
    const size_t shown = effects::has_many_values(*effect.definition) ? 1 : count;
    for (size_t i = 0; i < shown; ++i) {
      const effects::ParameterValue& value = effect.parameters[i];
      text += fmt::format("{}{} = {:.6g}", i == 0 ? "" : ", ",
                          effect.definition->parameters[i].name, value.value);
      if (value.sigma) text += fmt::format(" +- {:.2g}", *value.sigma);
      if (value.free) text += " (free)";
    }
    if (shown < count) text += fmt::format(", and {} more values", count - shown);
    text += "\n";
  }
  return text;
}

// A model does not know the size of its images: it is taken to be twice the principal point.
std::string lens_warnings(const effects::Model& model) {
  const effects::ModelEffect* base = effects::base_of(model, effects::Base::projection);
  if (base == nullptr) return "";
  const double width = 2 * base->value("cx_px") + 1, height = 2 * base->value("cy_px") + 1;
  if (!(width >= 2 && height >= 2 && width <= 1e5 && height <= 1e5)) return "";
  const int width_px = static_cast<int>(width + 0.5), height_px = static_cast<int>(height + 0.5);
  std::string text;
  for (const std::string& doubt : effects::lens_doubts(model, width_px, height_px))
    text += fmt::format("warning: for images of {} x {} px, twice the principal point: {}\n",
                        width_px, height_px, doubt);
  return text;
}

std::string model_text(const ConfigNode& root) {
  const effects::Model model = effects::Model::from_config(root);
  std::string text =
      fmt::format("model: {}, {} effects, {} steps of history\n{}", model.name(),
                  model.effects().size(), model.history().size(), effects_text(model));
  text += lens_warnings(model);
  for (const std::string& sentence : effects::not_pictured(model))
    text += fmt::format("warning: as a robot's camera it is refused: {}\n", sentence);
  // What the model's own values lead to is an error, with the first of them as its text.
  for (const effects::FormulaTrouble& trouble : effects::troubles_of_formulas(model)) {
    if (trouble.certain) throw InputError(fmt::format("{}: {}", root.file(), trouble.text));
    text += fmt::format("warning: {}\n", trouble.text);
  }
  return text;
}

// Reads the meshes and textures, too, where this build can: what is wrong with them is reported
// here, and not by the first frame.
template <class Named>
std::string assets_text(Named& named) {
  if (!render::reads_assets()) return "";
  const render::Assets assets = app::read_assets(named);
  if (assets.meshes.empty() && assets.textures.empty()) return "";
  size_t triangles = 0;
  for (const render::Mesh& mesh : assets.meshes) triangles += mesh.indices.size() / 3;
  return fmt::format("  files        {} meshes of {} triangles, {} textures\n",
                     assets.meshes.size(), triangles, assets.textures.size());
}

// Each program that a run would start is there and can be started; all that cannot are named.
void check_behaviours(const std::string& file, const Scenario& scenario) {
  std::vector<std::string> errors;
  for (const RobotSpec& robot : scenario.robots) {
    if (robot.behaviour.command.empty()) continue;
    try {
      app::find_behaviour(robot.behaviour.command.front(), robot.id);
    } catch (const InputError& error) {
      errors.push_back(fmt::format("{}: {}", file, error.what()));
    }
  }
  if (!errors.empty()) throw InputError(fmt::format("{}", fmt::join(errors, "\nseam: ")));
}

// The camera models inside are for effects/ to check, and for a run to take.
std::string scenario_text(const ConfigNode& root) {
  Scenario scenario = Scenario::from_file(root.file());
  check_behaviours(root.file(), scenario);
  app::models_of(scenario);
  const std::string assets = assets_text(scenario);
  std::string text =
      fmt::format("scenario: {}\n  duration     {:g} s, step {:g} s, seed {}\n", scenario.name,
                  scenario.duration.s(), scenario.step.s(), scenario.seed);
  text +=
      fmt::format("  objects      {}{}{}\n", scenario.objects.size(),
                  scenario.has_field ? ", a field" : "", scenario.ball.present ? ", a ball" : "");
  for (const RobotSpec& robot : scenario.robots) {
    const CameraSpec& camera = robot.camera;
    text += fmt::format("  robot        {}", robot.id);
    if (!camera.model_yaml.empty()) {
      const auto model =
          effects::Model::from_config(ConfigNode::from_text(camera.model_yaml, camera.model_name));
      text += fmt::format(", camera model {} of {} effects", model.name(), model.effects().size());
      for (const std::string& doubt :
           effects::lens_doubts(model, camera.width_px, camera.height_px))
        text += fmt::format("\nwarning: {}: {}", camera.model_name, doubt);
    }
    text += "\n";
  }
  text += assets;
  for (const std::string& note : scenario.notes()) text += fmt::format("warning: {}\n", note);
  return text;
}

std::string scene_text(const ConfigNode& root) {
  const auto scene = read_scene(root);
  std::vector<Primitive> objects;
  scene->primitives_at(SimTime(), objects);
  return fmt::format("scene: {} objects, shading {}\n", objects.size(),
                     scene->lighting().lambert ? "lambert" : "flat") +
         assets_text(scene->files());
}

std::string field_text(const ConfigNode& root) {
  FieldSpec field;
  read_config(root, [&](ConfigTable& table) { describe(table, field); });
  return fmt::format("field: {:g} m x {:g} m\n", 2 * field.half_length_m, 2 * field.half_width_m);
}

std::string robot_text(const ConfigNode& root) {
  RobotBody body;
  read_config(root, [&](ConfigTable& table) { describe(table, body); });
  std::string text =
      fmt::format("robot: {} joints, {} parts, footprint {:g} m x {:g} m\n", body.joint_count(),
                  body.parts.size(), body.footprint_length_m, body.footprint_width_m) +
      assets_text(body);
  for (const std::string& note : body.notes) text += fmt::format("warning: {}\n", note);
  return text;
}

std::string colour_table_text(const ConfigNode& root) {
  const auto table = render::ColourTable::from_config(root);
  std::string text = "colour table:\n";
  for (int channel = 0; channel < render::kColourChannels; ++channel) {
    int used = 0;
    for (const render::ColourRange& range : table.channel(channel))
      used += range.cr_min <= range.cr_max && range.cb_min <= range.cb_max;
    text += fmt::format("  {:<12} {} of {} segments\n", render::kColourNames[channel], used,
                        render::kLumaSegments);
  }
  return text;
}

std::string sweep_text(const ConfigNode& root) {
  const auto plan = app::SweepPlan::from_file(root.file());
  check_behaviours(root.file(), plan.scenario(0));
  return fmt::format("plan: {} runs of {}\n  columns      {}\n", plan.runs(),
                     plan.texts().scenario_name, fmt::join(app::table_columns(plan), ", "));
}

struct Format {
  const char* name;
  std::string (*text)(const ConfigNode& root);
};
constexpr Format kFormats[] = {
    {"seam-scenario/1", scenario_text}, {"seam-model/1", model_text},
    {"seam-scene/1", scene_text},       {"seam-field/1", field_text},
    {"seam-robot/1", robot_text},       {"seam-colour-table/1", colour_table_text},
    {"seam-sweep/1", sweep_text}};
constexpr const char* kSetFormat = "seam-measurement/1";

bool begins_with(const std::string& path, std::string_view magic) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::string start(magic.size(), '\0');
  return std::ifstream(path, std::ios::binary).read(start.data(), std::ssize(start)) &&
         start == magic;
}

bool is_log(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return false;
  return fs::path(path).extension() == ".mcap" || begins_with(path, "\x89MCAP0\r\n");
}

// Throws ExitCode 1 where the log has gaps.
void check_log(const std::string& path) {
  const auto log = scheduler::Log::open(path, scheduler::LogAccess::scanned);
  const scheduler::RunHeader& header = log.header();
  std::printf("%s: log of scenario %s\n  robots       %zu\n  until        %.9g s%s\n", path.c_str(),
              shown(header.scenario_name).c_str(), header.robots.size(), log.end_time().s(),
              log.end() ? "" : ", without an end");
  for (const mcap::Loss& loss : log.losses())
    std::printf("error: %s: %s\n", path.c_str(), shown(loss.what).c_str());
  const auto index =
      log.losses().empty() ? mcap::index_damage(log.file().contents()) : std::nullopt;
  if (index) {
    std::printf("warning: %s: %s; to write it anew: seam replay recover %s --out FILE\n",
                path.c_str(), shown(mcap::index_sentence(*index)).c_str(), path.c_str());
  }
  if (!log.losses().empty()) throw ExitCode{1};
}

// All errors are listed, then the exit code says whether there are any.
void check_set(const CheckSettings& settings) {
  const auto set = measurement::MeasurementSet::open(settings.path);
  std::optional<effects::Model> model;
  if (!settings.model.empty()) model = effects::Model::from_file(settings.model);
  const measurement::SetDescription description =
      measurement::describe_set(set, model, app::instruments());
  std::printf("%s: %s", settings.path.c_str(), shown_lines(description.text).c_str());
  for (const std::string& warning : description.warnings)
    std::printf("warning: %s\n", shown_lines(warning).c_str());
  for (const std::string& error : description.errors)
    std::printf("error: %s\n", shown_lines(error).c_str());
  std::printf("%zu errors, %zu warnings\n", description.errors.size(), description.warnings.size());
  if (!description.errors.empty()) throw ExitCode{1};
}

void check(const CheckSettings& settings) {
  if (is_log(settings.path)) return check_log(settings.path);
  if (fs::is_directory(settings.path)) return check_set(settings);
  app::refuse_foreign_file(settings.path);
  if (begins_with(settings.path, "SQLite format 3"))
    throw InputError(fmt::format(
        "{}: found a database; of the results of a sweep `seam sweep status` says what they hold",
        settings.path));
  const ConfigNode root = ConfigNode::from_file(settings.path);
  if (!root.has("format") && root.has("effects")) {
    std::printf("%s: effects of your own\n", settings.path.c_str());
    for (const auto& effect : effects_named(settings.path))
      std::printf("  %-12s %s\n", shown(effect->name).c_str(), to_string(effect->stage).c_str());
    return;
  }
  const std::string format = root.at("format").text();
  if (format == kSetFormat) return check_set(settings);
  std::vector<std::string> known = {kSetFormat};
  for (const Format& entry : kFormats) {
    known.emplace_back(entry.name);
    if (format != entry.name) continue;
    std::printf("%s: a valid %s\n%s", settings.path.c_str(), format.c_str(),
                shown_lines(entry.text(root)).c_str());
    return;
  }
  root.at("format").fail(fmt::format("found '{}'{}", format, suggestion_for(format, known)));
}

}  // namespace

void add_check(app::Command app) {
  app::Command command = app.add_subcommand(
      "check",
      "Validates a file of SEAM and prints what it holds: a scenario, model, measurement set, "
      "scene, field, robot, colour table, plan of a sweep or log");
  auto settings = std::make_shared<CheckSettings>();
  command.add_option("PATH", settings->path, "The file, or the folder of a measurement set")
      .required();
  command.add_option("--model", settings->model,
                     "Of a measurement set: what is behind this model's camera, and which effects "
                     "the set can test beside it");
  command.footer("Example: seam check sets/points-a --model nominal.yaml");
  command.callback([settings] { check(*settings); });
}

}  // namespace seam::tools
