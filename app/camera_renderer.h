// The scheduler's FrameRenderer by means of render/: one camera a robot, with the robot's model.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "effects/model.h"
#include "effects/stages/timing.h"
#include "render/colour/colour_detector.h"
#include "render/gl/device.h"
#include "render/renderer.h"
#include "scheduler/loop/frame_renderer.h"
#include "sim_core/scenario/scenario.h"

namespace seam::app {

class CameraRenderer final : public scheduler::FrameRenderer {
 public:
  // `models`: one a robot. `workers`: frames made at once; 0 is one for each core. `opengl` draws
  // in place of the ray caster where given. A camera is made when it is first used.
  CameraRenderer(const Scenario& scenario, const std::vector<effects::Model>& models,
                 int workers = 0, const render::RendererOptions& options = {},
                 std::unique_ptr<render::GlDevice> opengl = nullptr);

  int workers() const override { return workers_; }
  RowSchedule schedule(int robot, uint64_t frame_index, SimTime stamp) override;
  Pose mount(int robot) const override { return cameras_[robot].X_LC; }
  Frame render(int robot, const FrameJob& job, int worker) override;

  // Puts into a frame that was rendered elsewhere what follows from its rgb.
  void develop(int robot, Frame& frame) const;

  const render::RendererOptions& options() const { return options_; }
  // Throws InputError, naming the model's file, for one that cannot be rendered.
  const render::Renderer& camera(int robot) const;
  // Makes all of them now, so that an error is reported before a run begins.
  void make_cameras() const;

 private:
  void detect_colours(int robot, Frame& frame) const;

  struct MadeOnce {
    std::once_flag once;
    std::unique_ptr<render::Renderer> renderer;
  };
  struct Camera {
    std::string robot;
    effects::Model model;
    std::unique_ptr<MadeOnce> made;
    std::optional<render::ColourDetector> colours;
    effects::Timing timing;
    Pose X_LC;
    RandomStream stream;
    CameraSpec spec;
  };
  std::unique_ptr<render::GlDevice> opengl_;
  std::vector<Camera> cameras_;
  int workers_;
  render::RendererOptions options_;
};

}  // namespace seam::app
