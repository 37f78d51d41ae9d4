#include "app/camera_renderer.h"

#include <algorithm>
#include <cmath>
#include <thread>

#include "effects/stages/geometry.h"
#include "effects/stages/row_schedule.h"
#include "sim_core/base/error.h"

namespace seam::app {

CameraRenderer::CameraRenderer(const Scenario& scenario, const std::vector<effects::Model>& models,
                               int workers, const render::RendererOptions& options,
                               std::unique_ptr<render::GlDevice> opengl)
    : opengl_(std::move(opengl)),
      workers_(workers > 0
                   ? workers
                   : std::clamp<int>(static_cast<int>(std::thread::hardware_concurrency()), 1, 64)),
      options_(options) {
  SEAM_CHECK(models.size() == scenario.robots.size(), "{} models", models.size());
  options_.opengl = opengl_.get();
  for (size_t i = 0; i < models.size(); ++i) {
    const RobotSpec& robot = scenario.robots[i];
    Camera camera{.robot = robot.id, .model = models[i], .made = std::make_unique<MadeOnce>()};
    camera.spec = robot.camera;
    if (!robot.camera.colour_table_yaml.empty())
      camera.colours.emplace(render::ColourTable::from_config(
          ConfigNode::from_text(robot.camera.colour_table_yaml, robot.camera.colour_table_name)));
    camera.timing = effects::timing_of(models[i]);
    camera.X_LC = effects::mount_of(models[i]);
    camera.stream = camera_stream(scenario, robot);
    cameras_.push_back(std::move(camera));
  }
}

const render::Renderer& CameraRenderer::camera(int robot) const {
  const Camera& camera = cameras_[robot];
  const CameraSpec& spec = camera.spec;
  try {
    std::call_once(camera.made->once, [&] {
      camera.made->renderer =
          std::make_unique<render::Renderer>(camera.model, static_cast<int>(spec.width_px),
                                             static_cast<int>(spec.height_px), options_);
    });
  } catch (const InputError& error) {
    // What a model cannot be asked is said with the file that it came from.
    throw InputError(fmt::format(
        "{}: {}", spec.model_name.empty() ? "robot '" + camera.robot + "'" : spec.model_name,
        error.what()));
  }
  return *camera.made->renderer;
}

void CameraRenderer::make_cameras() const {
  for (size_t i = 0; i < cameras_.size(); ++i) camera(static_cast<int>(i));
}

RowSchedule CameraRenderer::schedule(int robot, uint64_t frame_index, SimTime stamp) {
  const Camera& camera = cameras_[robot];
  const effects::HeadCycle cycle{.start = SimTime() + camera.spec.lock_start,
                                 .length = camera.spec.lock_cycle};
  const effects::RowScheduleOptions options{
      .instants_per_row = static_cast<int>(camera.spec.instants_per_row),
      .jitter = SimDuration::from_s(camera.timing.own_latency_s(camera.stream, frame_index))};
  return effects::make_row_schedule(camera.timing,
                                    effects::stamp_in_lock(camera.timing, stamp, cycle),
                                    static_cast<int>(camera.spec.height_px), options);
}

void CameraRenderer::detect_colours(int robot, Frame& frame) const {
  const std::optional<render::ColourDetector>& colours = cameras_[robot].colours;
  if (!colours) return;
  render::Detections seen = colours->detect(frame.ycrcb, frame.width_px, frame.height_px);
  frame.colours = std::move(seen.bits);
  frame.colours_width_px = seen.width_px;
  frame.colours_height_px = seen.height_px;
}

Frame CameraRenderer::render(int robot, const FrameJob& job, int) {
  const Camera& camera = cameras_[robot];
  const render::Renderer& renderer = this->camera(robot);
  try {
    Frame frame = renderer.render(job);
    detect_colours(robot, frame);
    return frame;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: robot '{}', frame at {:.9g} s: {}", camera.spec.model_name,
                                 camera.robot, job.stamp.s(), error.what()));
  }
}

void CameraRenderer::develop(int robot, Frame& frame) const {
  render::develop(frame);
  detect_colours(robot, frame);
}

}  // namespace seam::app
