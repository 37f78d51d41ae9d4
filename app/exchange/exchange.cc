#include "app/exchange/exchange.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "app/exchange/camera_files.h"
#include "app/exchange/imu_files.h"
#include "app/exchange/model_json.h"
#include "app/exchange/servo_files.h"
#include "effects/questions.h"
#include "effects/stages/lens_domain.h"
#include "effects/stages/spline_grid.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

using effects::Model;
using effects::ModelEffect;
using effects::Projection;

// A model of this effect alone, on the base that projects.
Model alone(const Model& model, const std::string& effect) {
  Model one = model;
  for (const ModelEffect& other : model.effects()) {
    const bool base = other.definition->base != effects::Base::none;
    if (!base && other.definition->name != effect) one.remove(other.definition->name);
  }
  return one;
}

// Whether the image of a ray depends on the ray alone, as in all these formats: not on its colour,
// the time or the row.
bool is_plain_lens(const Projection& projection) {
  for (int i = 1; i < 16; ++i) {
    const double u = (projection.width_px() - 1) * (i % 4) / 3.0;
    const double v = (projection.height_px() - 1) * (i / 4) / 3.0;
    const auto ray = projection.unproject(u, v);
    if (!ray) continue;
    const effects::ImagePoint plain = projection.project(*ray);
    for (const auto& other :
         {projection.project(*ray, 1.7, 0, 1), projection.project(*ray, 0, 33, 1),
          projection.project(*ray, 0, 0, 0), projection.project(*ray, 0, 0, 2)}) {
      if (other.u != plain.u || other.v != plain.v) return false;
    }
  }
  return true;
}

// Whether the effect is a property of the camera. What acts on the target, the robot's joints, the
// lamps or the detector is none, nor is where the camera stands: a camera's file loses nothing
// without it.
bool is_of_camera(const effects::EffectDefinition& effect) {
  if (effect.base != effects::Base::none) return true;
  if (effect.geometry && !effect.columns.empty()) return true;  // Of no image, and yet the lens.
  return !effects::of_points_alone(effect) &&
         (effect.geometry || effect.image_map || effect.timing || effect.optics || effect.gain ||
          effect.sensor);
}

// A lens of splines that is all of the model's lens and covers whole degrees, as mrcal's does; null
// where the lens is another one.
const ModelEffect* splines_alone(const Model& model) {
  const ModelEffect* splines = nullptr;
  for (const ModelEffect& effect : model.effects()) {
    const effects::EffectDefinition& definition = *effect.definition;
    if (!(definition.geometry || definition.image_map) ||
        definition.base == effects::Base::projection)
      continue;
    const double fov_deg =
        effects::is_any_lens(definition) ? effect.values()[effects::kSplineFov] : 0.5;
    if (fov_deg != std::round(fov_deg)) return nullptr;
    splines = &effect;
  }
  return splines;
}

class Exporter {
 public:
  Exporter(const Model& model, const ExchangeFormat& format, const ExportOptions& options)
      : model_(model), format_(format), options_(options) {}

  Exported run();

 private:
  void find_size();
  bool holds(const ModelEffect& effect) const;
  LensFit find_lens(const Model& kept);
  void split(Model& kept, std::vector<const ModelEffect*>& lost);
  bool asked_to_drop(const std::string& name) const;
  void check_drops() const;
  std::string cost_of(const ModelEffect& effect) const;
  Projection projection_of(const Model& model) const {
    return Projection(model, camera_.width_px, camera_.height_px);
  }

  const Model& model_;
  const ExchangeFormat& format_;
  const ExportOptions& options_;
  PlainCamera camera_;
  Exported out_;
};

void Exporter::find_size() {
  camera_.width_px = options_.width_px, camera_.height_px = options_.height_px;
  if (camera_.width_px > 0) return;
  const ModelEffect* base = effects::base_of(model_, effects::Base::projection);
  camera_.width_px = static_cast<int>(std::lround(2 * base->value("cx_px") + 1));
  camera_.height_px = static_cast<int>(std::lround(2 * base->value("cy_px") + 1));
  if (camera_.width_px < 2 || camera_.height_px < 2)
    throw InputError(
        "the size of the image does not follow from the principal point: give it, "
        "--size WIDTHxHEIGHT");
  out_.notes.push_back(
      fmt::format("the image is taken to be {} x {} px, twice the principal point: a model does "
                  "not know its size (--size WIDTHxHEIGHT, or --data SET)",
                  camera_.width_px, camera_.height_px));
}

bool Exporter::holds(const ModelEffect& effect) const {
  const effects::EffectDefinition& definition = *effect.definition;
  if (definition.base == effects::Base::projection || definition.parameters.empty()) return true;
  if (!definition.columns.empty()) return false;
  if (definition.geometry || definition.image_map)
    return is_plain_lens(projection_of(alone(model_, definition.name)));
  if (definition.timing) {
    effects::Timing timing;
    definition.timing(effect.values(), timing);
    if (!format_.holds_line_delay && timing.line_delay_s != 0) return false;
    if (!format_.holds_time_shift && timing.latency_s != 0) return false;
    return timing.exposure_s == 0 && timing.drift_ppm == 0 && timing.jitter_sigma_s == 0 &&
           timing.sync_period_frames == 0;
  }
  return false;
}

bool Exporter::asked_to_drop(const std::string& name) const {
  return std::find(options_.drop.begin(), options_.drop.end(), name) != options_.drop.end();
}

void Exporter::check_drops() const {
  std::vector<std::string> names;
  for (const ModelEffect& effect : model_.effects()) names.push_back(effect.definition->name);
  for (const std::string& name : options_.drop) {
    const ModelEffect* effect = model_.find(name);
    if (effect != nullptr && effect->definition->base == effects::Base::projection)
      throw InputError(fmt::format("--drop {}: a camera is nothing without it", name));
    if (name == "all" || effect != nullptr) continue;
    throw InputError(
        fmt::format("--drop {}: the model has no such effect{}, expected one of its "
                    "effects or 'all'",
                    name, suggestion_for(name, names)));
  }
}

// What the file is wrong by without the effect, over the image.
std::string Exporter::cost_of(const ModelEffect& effect) const {
  const effects::EffectDefinition& definition = *effect.definition;
  if (definition.timing) {
    effects::Timing timing;
    definition.timing(effect.values(), timing);
    const double late_s = std::abs(timing.row_middle_after_stamp_s(camera_.height_px - 1.0, 0));
    if (late_s == 0) return "frames are no longer early or late by what it says";
    return fmt::format("up to {:.3g} px while the camera turns by 1 rad/s",
                       late_s * camera_.lens.fx_px);
  }
  if (!definition.columns.empty())
    return fmt::format("the camera no longer changes with {}", fmt::join(definition.columns, ", "));
  if (!definition.geometry && !definition.image_map)
    return "no image point moves: brightness and noise are not exported";
  Model without = model_;
  without.remove(definition.name);
  const Projection with = projection_of(model_), rest = projection_of(without);
  double most = 0;
  for (int channel = 0; channel < 3; ++channel) {
    for (int i = 0; i < 81; ++i) {
      const double u = (camera_.width_px - 1) * (i % 9) / 8.0;
      const double v = (camera_.height_px - 1) * (i / 9) / 8.0;
      const auto ray = with.unproject(u, v, 0, channel);
      if (!ray) continue;
      const effects::ImagePoint seen = rest.project(*ray, 0, v, channel);
      most = std::max(most, seen.visible ? std::hypot(seen.u - u, seen.v - v) : HUGE_VAL);
    }
  }
  return fmt::format("up to {:.3g} px over the image", most);
}

// What the format holds, and what it loses. What is no property of the camera is neither.
void Exporter::split(Model& kept, std::vector<const ModelEffect*>& lost) {
  std::vector<std::string> foreign;
  for (const ModelEffect& effect : model_.effects()) {
    const std::string& name = effect.definition->name;
    if (!is_of_camera(*effect.definition)) {
      foreign.push_back(name);
      kept.remove(name);
      continue;
    }
    if (holds(effect) && !asked_to_drop(name)) continue;
    if (!asked_to_drop(name) && !asked_to_drop("all"))
      throw InputError(
          fmt::format("{} cannot hold effect '{}': export with --drop {} to leave it "
                      "out and see what that costs, or --drop all",
                      format_.name, name, name));
    lost.push_back(&effect);
    kept.remove(name);
  }
  if (!foreign.empty())
    out_.notes.push_back(fmt::format("not in the file, since it is no property of the camera: {}",
                                     fmt::join(foreign, ", ")));
}

LensFit Exporter::find_lens(const Model& kept) {
  std::vector<LensFamily> families;
  std::vector<std::string> forms;
  for (const LensFamily family : format_.lenses) {
    const std::string form = name_of(form_of(family));
    if (std::find(forms.begin(), forms.end(), form) == forms.end()) forms.push_back(form);
    if (options_.form.empty() || options_.form == form) families.push_back(family);
  }
  if (families.empty())
    throw UsageError(fmt::format("--form {}: {} has no such form of a lens{}, expected {}",
                                 options_.form, format_.name, suggestion_for(options_.form, forms),
                                 fmt::join(forms, ", ")));
  // A model whose lens is another one than a perspective lens keeps its form.
  const bool wide =
      std::any_of(kept.effects().begin(), kept.effects().end(), [](const ModelEffect& effect) {
        return effects::replaces(*effect.definition, effects::Term::radial);
      });
  if (wide)
    std::stable_partition(families.begin(), families.end(),
                          [](LensFamily family) { return form_of(family) == LensForm::fisheye; });
  LensFit fit = best_lens(projection_of(kept), families);
  if (!std::isfinite(fit.rms_px))
    throw InputError(fmt::format(
        "{} has no {}lens that sees as wide as this model's: the image holds rays at right angles "
        "to the axis, expected --form fisheye or a format that has one",
        format_.name, options_.form.empty() ? "" : options_.form + " "));
  if (!fit.exact())
    out_.notes.push_back(
        fmt::format("{} has no lens of this form: its nearest misses by {:.3g} px "
                    "(root mean square), {:.3g} px at most over the image",
                    format_.name, fit.rms_px, fit.most_px));
  return fit;
}

Exported Exporter::run() {
  if (!effects::has_base(model_, effects::Base::projection))
    throw InputError(fmt::format("{} holds a camera, expected a model with '{}'", format_.name,
                                 effects::base_name(effects::Base::projection)));
  check_drops();
  find_size();
  Model kept = model_;
  std::vector<const ModelEffect*> lost;
  split(kept, lost);
  const ModelEffect* splines = format_.text_of_splines ? splines_alone(kept) : nullptr;
  if (splines && options_.form.empty()) {
    const ModelEffect& base = *effects::base_of(kept, effects::Base::projection);
    camera_.lens = {.fx_px = base.value("fx_px"),
                    .fy_px = base.value("fy_px"),
                    .cx_px = base.value("cx_px"),
                    .cy_px = base.value("cy_px")};
    out_.form = "splines over a stereographic projection";
    for (const std::string& doubt : effects::lens_doubts(kept, camera_.width_px, camera_.height_px))
      out_.notes.push_back(doubt);
  } else {
    splines = nullptr;
    camera_.lens = find_lens(kept).lens;
    out_.form = words_of(camera_.lens.family);
  }
  const effects::Timing timing = effects::timing_of(kept);
  camera_.name = model_.name().empty() ? "camera" : model_.name();
  camera_.line_delay_s = timing.line_delay_s;
  camera_.time_shift_s = timing.row_middle_after_stamp_s(0, 0);
  for (const ModelEffect* effect : lost)
    out_.notes.push_back(fmt::format("without {}: {}", effect->definition->name, cost_of(*effect)));
  out_.text = splines ? format_.text_of_splines(camera_, *splines) : format_.text(camera_);
  return out_;
}

}  // namespace

const std::vector<ExchangeFormat>& exchange_formats() {
  using enum LensFamily;
  static const std::vector<ExchangeFormat> formats = {
      {.name = "opencv",
       .help = "YAML of cv::FileStorage: camera_matrix, distortion_coefficients",
       .lenses = {pinhole, plumb_bob, rational, thin_prism, equidistant},
       .text = opencv_text},
      {.name = "ros",
       .help = "camera_info YAML",
       .lenses = {pinhole, plumb_bob, rational, equidistant},
       .text = ros_text},
      {.name = "mrcal",
       .help = "a .cameramodel",
       .ending = ".cameramodel",
       .lenses = {pinhole, radtan, plumb_bob, rational, thin_prism},
       .text = mrcal_text,
       .text_of_splines = mrcal_text_of_splines},
      {.name = "kalibr",
       .help = "a camchain, with line_delay and timeshift_cam_imu",
       .lenses = {radtan, equidistant},
       .holds_line_delay = true,
       .holds_time_shift = true,
       .text = kalibr_text},
      {.name = "mjcf",
       .help = "a joint's and a position actuator's attributes for MuJoCo",
       .ending = ".xml",
       .text_of_servo = mjcf_text,
       .holds_servo = mjcf_holds,
       .holds_gain = true},
      {.name = "urdf",
       .help = "a joint's dynamics and limits for a URDF",
       .ending = ".xml",
       .text_of_servo = urdf_text,
       .holds_servo = urdf_holds},
      {.name = "kalibr-imu",
       .help = "an imu.yaml: white noise and random walk of gyroscope and accelerometer",
       .text_of_imu = kalibr_imu_text},
      {.name = "vins-imu",
       .help = "the same for the YAML of VINS-Mono and VINS-Fusion: acc_n, gyr_n, acc_w, gyr_w",
       .text_of_imu = vins_imu_text},
      {.name = "kalibr-imu-cam",
       .help = "of a camchain-imucam.yaml: T_cam_imu without the lever arm, and timeshift_cam_imu",
       .text_of_rig = kalibr_rig_text},
      {.name = "vins-imu-cam",
       .help = "the same for the YAML of VINS-Fusion: body_T_cam0 and td",
       .text_of_rig = vins_rig_text},
      {.name = "json",
       .help = "all of the model, with its sigmas",
       .ending = ".json",
       .text_of_all = json_text}};
  return formats;
}

const ExchangeFormat& exchange_format_named(const std::string& name, const std::string& option) {
  std::vector<std::string> names;
  for (const ExchangeFormat& format : exchange_formats()) {
    if (format.name == name) return format;
    names.push_back(format.name);
  }
  throw UsageError(
      fmt::format("{}: unknown format '{}'{}", option, name, suggestion_for(name, names)));
}

Exported export_model(const Model& model, const ExchangeFormat& format,
                      const ExportOptions& options) {
  if (!options.form.empty() && format.text == nullptr)
    throw UsageError(
        fmt::format("--form {}: {} holds no form of a lens to choose", options.form, format.name));
  if (format.text_of_all != nullptr)
    return {.text = format.text_of_all(model), .form = "", .notes = {}};
  if (format.text_of_servo != nullptr) return export_servo(model, format, options);
  if (format.text_of_imu != nullptr) return export_imu(model, format, options);
  if (format.text_of_rig != nullptr) return export_rig(model, format, options);
  return Exporter(model, format, options).run();
}

}  // namespace seam::app
