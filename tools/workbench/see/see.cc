#include "tools/workbench/see/see.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "effects/questions.h"
#include "effects/registry.h"
#include "effects/stages/row_schedule.h"
#include "effects/stages/timing.h"
#include "render/renderer.h"
#include "sim_core/base/error.h"
#include "sim_core/scene/board.h"

namespace seam::tools {
namespace {

using effects::EffectDefinition;
using effects::Model;
using effects::ModelEffect;
using nlohmann::json;

constexpr uint16_t kBoard = 1;
// Of a frame: its rays take a gigabyte. Larger ones would be made, but nobody could wait for them.
constexpr double kMostPixels = 20e6;
// A coarse frame has at most so many pixels: it is there within 100 ms on two cores.
constexpr int kMostCoarsePixels = 40'000;

// The half widths of what the camera sees at a distance of 1 m, by its focal lengths; of a camera
// that sees more than 127 degrees those of this angle, where a board can still stand.
struct Extent {
  double across_m = 0.5, up_m = 0.4;
};

Extent extent_of(const Model& model, const SeeSettings& settings) {
  constexpr double kMost_m = 2;
  Extent extent;
  for (const ModelEffect& effect : model.effects()) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const std::string& name = effect.definition->parameters[i].name;
      const double value = effect.parameters[i].value;
      if (name == "fx_px") extent.across_m = std::min(kMost_m, 0.5 * settings.width_px / value);
      if (name == "fy_px") extent.up_m = std::min(kMost_m, 0.5 * settings.height_px / value);
    }
  }
  return extent;
}

Primitive post(const Vec3& base, double height_m, const Rgb& rgb, uint16_t id) {
  return {.shape = Shape::cylinder,
          .object_id = id,
          .X_WO = translation(base),
          .size = {0.035 * height_m, 0, height_m},
          .rgb = rgb};
}

// The board 1 m ahead fills seven tenths of the image, posts stand beside it; the camera looks
// along +x when the head is straight.
std::vector<Primitive> scenery(const Extent& extent) {
  BoardSpec board;
  board.pitch_m = std::min(1.4 * extent.across_m / static_cast<double>(board.columns + 2),
                           1.4 * extent.up_m / static_cast<double>(board.rows + 2));
  board.border_m = board.pitch_m;
  const Mat3 facing(Vec3{0, -1, 0}, Vec3{0, 0, 1}, Vec3{-1, 0, 0});
  std::vector<Primitive> all = board_primitives(board, {facing, {1, 0, 0}}, kBoard);
  const double side_m = 0.85 * extent.across_m, foot_m = -0.9 * extent.up_m;
  all.push_back(post({1, side_m, foot_m}, 1.7 * extent.up_m, {0.85, 0.25, 0.45}, 2));
  all.push_back(post({1, -side_m, foot_m}, 1.7 * extent.up_m, {0.05, 0.4, 0.75}, 3));
  return all;
}

FrameJob job_of(const Model& model, const SeeSettings& settings) {
  FrameJob job{.robot = "camera", .stamp = SimTime()};
  job.schedule =
      effects::make_row_schedule(effects::timing_of(model), job.stamp, settings.height_px,
                                 {.instants_per_row = settings.coarse ? 4 : 8});
  job.scenery = scenery(extent_of(model, settings));
  for (const SimTime time : job.schedule.instants) {
    const double pan_rad = settings.head_rate_radps * time.s();
    job.instants.push_back(
        {.time = time,
         .X_WC = rotation(rotation_about({0, 0, 1}, pan_rad)) * rotation(link_to_camera_axes()),
         .primitives = {},
         .figures = {}});
  }
  job.background = {0.32, 0.34, 0.36};
  job.camera_noise = {.seed = 1, .stream = 1};
  job.frame_noise = job.camera_noise.child("frame").child(job.frame_index);
  return job;
}

// The same camera with k times fewer rows and columns: lengths in pixels are k times shorter, what
// is stated by the row takes k times as long. A formula on the image is not known to, which the
// fine frame shows right.
Model with_fewer_pixels(Model model, int k) {
  for (const ModelEffect& effect : std::vector<ModelEffect>(model.effects())) {
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::Parameter& parameter = effect.definition->parameters[i];
      const double value = effect.parameters[i].value;
      double scaled = value;
      if (parameter.name.ends_with("_px")) scaled = value / k;
      if (parameter.name.starts_with("line_")) scaled = value * k;
      if (scaled != value)
        model.set_value(effect.definition->name, i,
                        std::clamp(scaled, parameter.min, parameter.max));
    }
  }
  return model;
}

// A model of flat fields has no lens: a perspective of 53 degrees shows what it does.
void give_projection(Model& model, const SeeSettings& settings) {
  if (effects::has_base(model, effects::Base::projection)) return;
  const auto definition = effects::find_effect(effects::base_name(effects::Base::projection));
  std::vector<effects::ParameterValue> values;
  for (const effects::Parameter& parameter : definition->parameters) {
    const double middle = parameter.name == "cx_px"   ? 0.5 * (settings.width_px - 1)
                          : parameter.name == "cy_px" ? 0.5 * (settings.height_px - 1)
                                                      : settings.width_px;
    values.push_back({.value = middle});
  }
  model.set(definition, std::move(values));
}

// What shows in an image.
bool shows(const EffectDefinition& effect) {
  return effects::acts_in_runs(effect) && !effects::of_points_alone(effect) &&
         (effect.timing || effect.geometry || effect.image_map || effect.optics || effect.gain ||
          effect.light || effect.sensor);
}

json sliders_of(const EffectDefinition& effect, const ModelEffect* in_model) {
  json parameters = json::array();
  for (size_t i = 0; i < effect.parameters.size(); ++i) {
    const effects::Parameter& parameter = effect.parameters[i];
    const double value = in_model ? in_model->parameters[i].value : parameter.neutral;
    if (parameter.integer || !std::isfinite(value)) continue;
    // Some typical sizes to both sides, so that what the effect does is seen.
    const double reach = std::max(4 * parameter.scale, 0.3 * std::abs(value));
    parameters.push_back({{"name", parameter.name},
                          {"value", value},
                          {"low", std::max(parameter.min, value - reach)},
                          {"high", std::min(parameter.max, value + reach)},
                          {"help", parameter.help}});
  }
  return {{"name", effect.name},
          {"in_model", in_model != nullptr},
          {"help", effect.help},
          {"parameters", std::move(parameters)}};
}

}  // namespace

SeenFrame see(const Model& whole, const SeeSettings& settings) {
  if (settings.width_px <= 0 || settings.height_px <= 0)
    throw InputError("this set has no camera, whose image could be shown");
  Model model = effects::without_points_own(whole);
  give_projection(model, settings);
  SeeSettings shown = settings;
  const double pixels = static_cast<double>(settings.width_px) * settings.height_px;
  if (pixels > kMostPixels)
    throw InputError(fmt::format("camera: found {} by {} pixels, See it shows at most {} million",
                                 settings.width_px, settings.height_px, kMostPixels / 1e6));
  if (settings.coarse && pixels > kMostCoarsePixels) {
    const int k = static_cast<int>(std::ceil(std::sqrt(pixels / kMostCoarsePixels)));
    model = with_fewer_pixels(std::move(model), k);
    shown.width_px = std::max(1, settings.width_px / k);
    shown.height_px = std::max(1, settings.height_px / k);
  }
  render::RendererOptions options;
  if (settings.coarse) options.samples_per_pixel = 2, options.edge_samples_per_pixel = 8;
  options.threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 8U));
  const render::Renderer renderer(model, shown.width_px, shown.height_px, options);
  Frame frame = renderer.render(job_of(model, shown));
  return {frame.width_px, frame.height_px, std::move(frame.rgb)};
}

void take_values(Model& model, const json& effects) {
  for (const ModelEffect& effect : std::vector<ModelEffect>(model.effects())) {
    const std::string& name = effect.definition->name;
    if (!effects.contains(name)) continue;
    for (size_t i = 0; i < effect.parameters.size(); ++i) {
      const effects::Parameter& parameter = effect.definition->parameters[i];
      const json value = effects[name].value(parameter.name, json::object()).value("value", json());
      if (value.is_number())
        model.set_value(name, i, std::clamp(value.get<double>(), parameter.min, parameter.max));
    }
  }
}

void change_parameters(Model& model, const json& changes) {
  if (!changes.is_object()) throw UsageError("changes: expected {EFFECT: {PARAMETER: VALUE}}");
  for (const auto& [name, values] : changes.items()) {
    if (!model.has(name)) {
      const auto definition = effects::find_effect(name);
      if (!definition || !definition->has_neutral)
        throw UsageError(fmt::format("changes: found '{}', expected an effect", name));
      model.add_neutral(definition);
    }
    const EffectDefinition& effect = *model.find(name)->definition;
    for (const auto& [key, value] : values.items()) {
      const auto found = std::ranges::find(effect.parameters, key, &effects::Parameter::name);
      if (found == effect.parameters.end() || !value.is_number())
        throw UsageError(fmt::format("changes: {} has no number '{}'", name, key));
      const double number = value.get<double>();
      if (!(number >= found->min && number <= found->max))
        throw UsageError(fmt::format("changes: {}.{} is {}, expected {} to {}", name, key, number,
                                     found->min, found->max));
      model.set_value(name, static_cast<size_t>(found - effect.parameters.begin()), number);
    }
  }
}

json sliders_json(const Model& model) {
  json list = json::array();
  for (const ModelEffect& effect : model.effects()) {
    if (shows(*effect.definition)) list.push_back(sliders_of(*effect.definition, &effect));
  }
  for (const auto& definition : effects::catalogue()) {
    if (!model.has(definition->name) && definition->has_neutral && shows(*definition) &&
        effects::missing_base(*definition, model).empty() &&
        !effects::is_excluded(*definition, model))
      list.push_back(sliders_of(*definition, nullptr));
  }
  return list;
}

}  // namespace seam::tools
