#include "app/camera_warnings.h"

#include <cstdio>

#include "render/assets/enclosed.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"

namespace seam::app {
namespace {

void say(const std::string& warning) {
  std::fprintf(stderr, "warning: %s\n", shown(warning).c_str());
}

void say_notes(const Simulator& simulator) {
  for (const std::string& note : simulator.scenario.notes()) say(note);
}

// What the camera is inside of; empty where it is free.
std::string around_camera(const std::vector<Primitive>& scenery, const SceneInstant& view,
                          const render::Assets& assets) {
  const auto holds = [&](const Primitive& primitive) {
    return render::is_inside(primitive, primitive.X_WO.inverse() * view.X_WC.p, assets);
  };
  for (const auto* primitives : {&scenery, &view.primitives})
    for (const Primitive& primitive : *primitives)
      if (holds(primitive)) return "an object of the scenario";
  for (const FigureAt& at : view.figures) {
    std::vector<Primitive> parts;
    at.figure->add_parts(at.posture, parts);
    for (size_t i = 0; i < parts.size(); ++i)
      if (holds(parts[i])) return at.figure->part_name(i);
  }
  return "";
}

void warn_of_view(const Simulator& simulator, size_t robot, const std::vector<Primitive>& scenery,
                  const SceneInstant& view) {
  static const render::Assets kNone;
  const render::GlDevice* const opengl = simulator.renderer->options().opengl;
  const std::string what = around_camera(scenery, view, opengl ? opengl->assets() : kNone);
  if (what.empty()) return;
  say(
      fmt::format("robot '{}', at {:g} s: its camera is inside {} and sees nothing but the inner "
                  "side: move the "
                  "camera (body.camera.translate_m), or put it on another link (body.camera.link)",
                  simulator.scenario.robots[robot].id, view.time.s(), what));
}

}  // namespace

void warn_of_robots(const Simulator& simulator) {
  say_notes(simulator);
  const World& world = simulator.world;
  for (size_t i = 0; i < simulator.scenario.robots.size(); ++i)
    warn_of_view(simulator, i, world.scenery(),
                 world.view_of(i, world.start(), simulator.renderer->mount(static_cast<int>(i))));
}

void warn_of_frame(const Simulator& simulator, size_t robot, const FrameJob& job) {
  say_notes(simulator);
  if (!job.instants.empty()) warn_of_view(simulator, robot, job.scenery, job.instants.front());
}

}  // namespace seam::app
