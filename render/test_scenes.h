// Scenes as functions of time for the tests and benchmarks of this folder, and jobs made from them.
#pragma once

#include <cstdlib>
#include <functional>
#include <string>

#include "effects/model.h"
#include "effects/stages/row_schedule.h"
#include "sim_core/base/config.h"
#include "sim_core/scene/frame.h"

namespace seam::render::testing {

// The ERS-210's camera, which most tests look through.
inline constexpr int kWidth = 178, kHeight = 144;
inline constexpr double kFx = 161.9, kFy = 162.5, kCx = 88.5, kCy = 71.5;

// Where OpenGL of tests and benchmarks comes from, for GlDevice: SEAM_GL=egl takes a graphics
// processor.
inline const char* gl_source() {
  const char* const given = std::getenv("SEAM_GL");
  return given ? given : "auto";
}

struct MovingScene {
  std::function<Pose(double t_s)> camera;  // X_WC.
  std::function<std::vector<Primitive>(double t_s)> primitives;
  Rgb background{0.45, 0.45, 0.5};
  Lighting lighting;
};

inline SceneInstant instant_at(const MovingScene& scene, SimTime time) {
  return {.time = time, .X_WC = scene.camera(time.s()), .primitives = scene.primitives(time.s())};
}

inline FrameJob job_of(const MovingScene& scene, const effects::Model& model, int height_px,
                       double stamp_s, int instants_per_row = 8) {
  FrameJob job{.robot = "test", .stamp = SimTime::from_s(stamp_s)};
  job.schedule = effects::make_row_schedule(effects::timing_of(model), job.stamp, height_px,
                                            {.instants_per_row = instants_per_row});
  for (const SimTime time : job.schedule.instants) job.instants.push_back(instant_at(scene, time));
  job.background = scene.background;
  job.lighting = scene.lighting;
  job.camera_noise = {.seed = 1, .stream = 2};
  job.frame_noise = job.camera_noise.child("frame").child(job.frame_index);
  return job;
}

inline effects::Model model_of(const std::string& effects) {
  return effects::Model::from_config(ConfigNode::from_text(
      "format: seam-model/1\nname: test\neffects:\n" + effects, "test model"));
}

// Looks along the link's +x: pan to the left, tilt upwards, both about the axes' crossing at
// `height_m`, the camera `lever_m` ahead.
inline Pose head_camera(double height_m, double pan_rad, double tilt_up_rad, double lever_m) {
  return translation({0, 0, height_m}) * rotation(rotation_about({0, -1, 0}, tilt_up_rad)) *
         rotation(rotation_about({0, 0, 1}, pan_rad)) * translation({lever_m, 0, 0}) *
         rotation(link_to_camera_axes());
}

inline Primitive sphere(const Vec3& centre, double radius, Rgb rgb) {
  return {.shape = Shape::sphere, .X_WO = translation(centre), .size = {radius, 0, 0}, .rgb = rgb};
}
inline Primitive upright_cylinder(const Vec3& base, double radius, double height, Rgb rgb) {
  return {
      .shape = Shape::cylinder, .X_WO = translation(base), .size = {radius, 0, height}, .rgb = rgb};
}
inline Primitive ground(const Vec3& centre, double length, double width, Rgb rgb) {
  return {.shape = Shape::rectangle,
          .X_WO = translation(centre),
          .size = {length, width, 0},
          .rgb = rgb};
}
inline Primitive box(const Vec3& centre, const Vec3& size, double yaw_rad, Rgb rgb) {
  return {.shape = Shape::box,
          .X_WO = translation(centre) * rotation(rotation_about({0, 0, 1}, yaw_rad)),
          .size = size,
          .rgb = rgb};
}
inline Primitive capsule(const Vec3& from, const Vec3& to, double radius, Rgb rgb) {
  const Vec3 along = to - from;
  const double length = std::sqrt(glm::dot(along, along));
  const Vec3 z = along / length;
  const Vec3 helper = std::abs(z.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  Vec3 x = glm::cross(helper, z);
  x /= std::sqrt(glm::dot(x, x));
  return {.shape = Shape::capsule,
          .X_WO = {Mat3(x, glm::cross(z, x), z), from},
          .size = {radius, 0, length},
          .rgb = rgb};
}

}  // namespace seam::render::testing
