#include "render/golden/golden_frames.h"

#include <fmt/format.h>

#include "effects/stages/row_schedule.h"
#include "render/renderer.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/maths.h"

namespace seam::render {
namespace {

constexpr const char* kPlain =
    "  pinhole: {fx_px: 161.9, fy_px: 162.5, cx_px: 88.5, cy_px: 71.5}\n"
    "  rolling_shutter: {line_delay_s: 2.78e-4}\n"
    "  exposure: {exposure_s: 0.005}\n";

constexpr const char* kFull =
    "  radial_distortion: {kappa: -0.08}\n"
    "  tangential_distortion: {p1: 0.0005, p2: -0.0003}\n"
    "  chromatic_aberration: {red_scale: 0.002, blue_scale: -0.001}\n"
    "  lens_blur: {sigma_px: 1.0}\n"
    "  vignetting: {a2: 0.25, a4: 0.05}\n"
    "  veiling_glare: {fraction: 0.02}\n"
    "  lamp_flicker: {frequency_hz: 100, depth: 0.05, phase_rad: 0.3}\n"
    "  shot_noise: {electrons_per_dn: 3}\n"
    "  dark_current: {electrons_per_s: 500}\n"
    "  pixel_gain_spread: {sigma: 0.01}\n"
    "  pixel_offset_spread: {sigma_dn: 0.5}\n"
    "  column_offsets: {sigma_dn: 0.4}\n"
    "  row_noise: {sigma_dn: 0.3}\n"
    "  hot_pixels: {fraction: 0.0005, level_dn: 60}\n"
    "  response_gamma: {gamma: 0.9}\n"
    "  white_balance: {red_gain: 1.05, blue_gain: 0.95}\n"
    "  read_noise: {sigma_dn: 1.5}\n"
    "  saturation: {full_dn: 250}\n"
    "  quantisation: {bits: 7}\n";

Primitive solid(Shape shape, const Pose& X_WO, const Vec3& size, const Rgb& rgb) {
  return {.shape = shape, .X_WO = X_WO, .size = size, .rgb = rgb};
}

// A head that swings over carpet, line, ball, beacon, box and capsule, all in motion.
SceneInstant scene_at(SimTime time) {
  const double t = time.s();
  const Pose head = translation({0, 0, 0.22}) *
                    rotation(rotation_zyx(0.02, 0.15 + 0.8 * (t - 0.02), 3 * (t - 0.02))) *
                    translation({0.0666, 0, 0}) * rotation(link_to_camera_axes());
  const double swing = 0.4 * maths::sin(20 * t);
  SceneInstant scene{.time = time, .X_WC = head, .primitives = {}};
  scene.primitives = {
      solid(Shape::rectangle, {}, {4.2, 2.7, 0}, {0.05, 0.35, 0.08}),
      solid(Shape::rectangle, translation({1, 0, 0}), {0.025, 2, 0}, {0.8, 0.8, 0.8}),
      solid(Shape::sphere, translation({0.8 - t, 0.1 + t, 0.042}), {0.042, 0, 0}, {0.9, 0.3, 0.02}),
      solid(Shape::cylinder, translation({1.2, 0.5, 0}), {0.05, 0, 0.4}, {0.9, 0.4, 0.5}),
      solid(Shape::box, {rotation_about({0, 0, 1}, 0.4), {1.1, -0.3, 0.1}}, {0.3, 0.2, 0.2},
            {0.2, 0.5, 0.9}),
      solid(Shape::capsule, {rotation_about({1, 0, 0}, swing), {0.7, -0.1, 0.05}}, {0.02, 0, 0.1},
            {0.7, 0.1, 0.1})};
  return scene;
}

GoldenFrame golden_frame(const char* name, const std::string& effects, const Lighting& lighting) {
  const effects::Model model = effects::Model::from_config(
      ConfigNode::from_text("format: seam-model/1\nname: golden\neffects:\n" + effects, "golden"));
  FrameJob job{.robot = "golden", .frame_index = 3, .stamp = SimTime::from_ns(1'000'003)};
  job.schedule = effects::make_row_schedule(effects::timing_of(model), job.stamp, 144);
  for (const SimTime time : job.schedule.instants) job.instants.push_back(scene_at(time));
  job.background = {0.45, 0.45, 0.5};
  job.lighting = lighting;
  job.camera_noise = {.seed = 11, .stream = 5};
  job.frame_noise = job.camera_noise.child("frame").child(job.frame_index);
  return {name, model, job};
}

}  // namespace

std::vector<GoldenFrame> golden_frames() {
  const Lighting lambert{
      .lambert = true, .direction_W = {0.36, 0.48, 0.8}, .ambient = 0.4, .diffuse = 0.6};
  return {golden_frame("plain", kPlain, {}), golden_frame("lambert", kPlain, lambert),
          golden_frame("full", std::string(kPlain) + kFull, {})};
}

std::string golden_frame_lines(int threads) {
  std::string lines;
  for (const GoldenFrame& golden : golden_frames()) {
    const Frame frame = Renderer(golden.model, 178, 144, {.threads = threads}).render(golden.job);
    lines += fmt::format("{} {}\n", golden.name, to_hex(frame.fingerprint));
  }
  return lines;
}

}  // namespace seam::render
