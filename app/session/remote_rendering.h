// Frames of a run that `seam-render` processes make: the two ends of it that know cameras.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/command_line.h"
#include "app/session/behaviours.h"
#include "app/simulator.h"
#include "scheduler/remote_render/remote_renderer.h"

namespace seam::app {

struct RemoteRenderingOptions {
  int renderers = 0;                // 0: the server renders.
  double connect_limit_s = 60;      // Wall time until all of them are here.
  std::string policy = "fallback";  // Or "abort", see scheduler::RendererPolicy.
  scheduler::RemoteRendererOptions frames;
};

// In front of the simulator's own renderer. The simulator must outlive it.
std::unique_ptr<scheduler::RemoteRenderer> make_remote_renderer(
    const Simulator& simulator, const RemoteRenderingOptions& options,
    const scheduler::RemoteRenderer::TellFault& tell_fault);

// The renderer's side: the cameras that a server announced.
std::unique_ptr<scheduler::FrameRenderer> make_told_renderer(const scheduler::RenderSetup& setup,
                                                             int threads);

// `seam-render` processes on this machine, for `seam run`.
std::vector<BehaviourProcess> render_processes(int count, const std::string& address,
                                               const std::string& token);

void add_remote_rendering_options(Command command, RemoteRenderingOptions& options);

}  // namespace seam::app
