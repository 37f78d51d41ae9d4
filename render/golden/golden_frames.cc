#include "render/golden/golden_frames.h"

#include <fmt/format.h>

#include "effects/stages/row_schedule.h"
#include "render/gl/device.h"
#include "render/renderer.h"
#include "render/test_scenes.h"
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

// A ring of triangles, a quarter of them with a picture.
Mesh ring() {
  constexpr uint32_t kAround = 24, kTube = 12;
  Mesh mesh;
  for (uint32_t a = 0; a <= kAround; ++a) {
    for (uint32_t b = 0; b <= kTube; ++b) {
      const double s = 2 * maths::kPi * (a % kAround) / kAround;
      const double t = 2 * maths::kPi * (b % kTube) / kTube;
      const Vec3 n(maths::cos(t) * maths::cos(s), maths::cos(t) * maths::sin(s), maths::sin(t));
      const Vec3 p = Vec3(0.15 * maths::cos(s), 0.15 * maths::sin(s), 0) + 0.05 * n;
      MeshVertex vertex{};
      for (int k = 0; k < 3; ++k) {
        vertex.p[k] = static_cast<float>(p[k]), vertex.n[k] = static_cast<float>(n[k]);
        vertex.rgb[k] = 0.9f - 0.2f * static_cast<float>(k);
      }
      vertex.uv[0] = 2 * static_cast<float>(a) / kAround,
      vertex.uv[1] = static_cast<float>(b) / kTube;
      mesh.vertices.push_back(vertex);
      if (a == kAround || b == kTube) continue;
      const uint32_t i = a * (kTube + 1) + b, j = i + kTube + 1;
      for (const uint32_t index : {i, j, j + 1, i, j + 1, i + 1}) mesh.indices.push_back(index);
    }
  }
  const auto all = static_cast<uint32_t>(mesh.indices.size()), quarter = all / 12 * 3;
  mesh.parts = {{.first = 0, .count = quarter, .picture = 0},
                {.first = quarter, .count = all - quarter}};
  mesh.radius_m = 0.21;
  return mesh;
}

Picture waves() {
  constexpr int kSide = 48;
  Picture picture{.width_px = kSide, .height_px = kSide, .rgb = {}};
  for (int i = 0; i < kSide * kSide; ++i) {
    for (const int part : {i % kSide * 5, i / kSide * 5, (i % kSide) * (i / kSide) % 256})
      picture.rgb.push_back(static_cast<uint8_t>(part));
  }
  return picture;
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

std::string opengl_frame_lines() {
  Assets assets;
  assets.textures.push_back({std::make_shared<Picture>(waves()), ""});
  assets.meshes.push_back(ring());
  assets.meshes[0].pictures.push_back(std::make_shared<Picture>(waves()));
  const GlDevice device(std::move(assets), testing::gl_source());
  std::vector<GoldenFrame> frames = golden_frames();
  for (const bool lambert : {false, true}) {
    GoldenFrame meshes = frames[lambert ? 1 : 2];
    meshes.name = lambert ? "meshes-lambert" : "meshes";
    for (SceneInstant& instant : meshes.job.instants) {
      const double turned = 3 * instant.time.s();
      instant.primitives[0].asset = 1;
      instant.primitives.push_back({.shape = Shape::mesh,
                                    .X_WO = {rotation_zyx(0.5, 0.3, turned), {0.9, 0.2, 0.2}},
                                    .size = Vec3(0.21),
                                    .rgb = {1, 1, 1},
                                    .asset = 1});
    }
    frames.push_back(meshes);
  }
  std::string lines = fmt::format("{}\n", device.version());
  for (const GoldenFrame& golden : frames) {
    const Frame frame = Renderer(golden.model, 178, 144, {.opengl = &device}).render(golden.job);
    lines += fmt::format("{} {}\n", golden.name, to_hex(frame.fingerprint));
  }
  return lines;
}

}  // namespace seam::render
