#include "app/session/remote_rendering.h"

#include <algorithm>
#include <filesystem>
#include <thread>

#include "render/assets/assets_bytes.h"
#include "sim_core/base/error.h"

namespace seam::app {

namespace {

// One message has them all, and clients take no longer ones than 64 MiB.
constexpr size_t kMostAssetBytes = size_t{60} << 20;

scheduler::RenderSetup setup_of(const Simulator& simulator) {
  const Scenario& scenario = simulator.scenario;
  const render::RendererOptions& rendering = simulator.renderer->options();
  scheduler::RenderSetup setup{.version = SEAM_VERSION,
                               .background = simulator.world.background(),
                               .lighting = simulator.world.lighting(),
                               .samples_per_pixel = rendering.samples_per_pixel,
                               .edge_samples_per_pixel = rendering.edge_samples_per_pixel,
                               .max_motion_px = rendering.max_motion_px,
                               .reference = rendering.reference};
  if (rendering.opengl) {
    setup.opengl = rendering.opengl->version();
    setup.opengl_from = rendering.opengl->source();
    setup.assets = render::bytes_of(rendering.opengl->assets());
    if (setup.assets.size() > kMostAssetBytes)
      throw InputError(fmt::format(
          "--renderers: meshes and textures of {} bytes, expected at most {} for frames made "
          "elsewhere",
          setup.assets.size(), kMostAssetBytes));
  }
  simulator.world.primitives_at(simulator.world.start(), setup.scene);
  for (const RobotSpec& robot : scenario.robots)
    setup.cameras.push_back({robot.id, static_cast<int>(robot.camera.width_px),
                             static_cast<int>(robot.camera.height_px), robot.camera.model_yaml,
                             robot.camera.model_name});
  return setup;
}

}  // namespace

std::unique_ptr<scheduler::RemoteRenderer> make_remote_renderer(
    const Simulator& simulator, const RemoteRenderingOptions& options,
    const scheduler::RemoteRenderer::TellFault& tell_fault) {
  CameraRenderer& local = *simulator.renderer;
  scheduler::RemoteRendererOptions frames = options.frames;
  if (options.policy == "abort") frames.policy = scheduler::RendererPolicy::abort;
  return std::make_unique<scheduler::RemoteRenderer>(
      local, setup_of(simulator), frames,
      [&local](int robot, Frame& frame) { local.develop(robot, frame); }, tell_fault);
}

std::unique_ptr<scheduler::FrameRenderer> make_told_renderer(const scheduler::RenderSetup& setup,
                                                             int threads) {
  // Colour tables stay with the server, which finds colours in the pixels that it is given.
  Scenario scenario;
  for (const scheduler::RenderCamera& camera : setup.cameras) {
    RobotSpec& robot = scenario.robots.emplace_back();
    robot.id = camera.robot;
    robot.camera.width_px = camera.width_px;
    robot.camera.height_px = camera.height_px;
    robot.camera.model_yaml = camera.model_yaml;
    robot.camera.model_name = camera.model_name;
  }
  std::unique_ptr<render::GlDevice> opengl;
  if (!setup.opengl.empty()) {
    opengl = std::make_unique<render::GlDevice>(render::assets_of(setup.assets), setup.opengl_from);
    if (opengl->version() != setup.opengl)
      throw InputError(fmt::format("OpenGL: found {}, expected the server's, {}", opengl->version(),
                                   setup.opengl));
  }
  return std::make_unique<CameraRenderer>(
      scenario, models_of(scenario), threads,
      render::RendererOptions{.samples_per_pixel = setup.samples_per_pixel,
                              .edge_samples_per_pixel = setup.edge_samples_per_pixel,
                              .max_motion_px = setup.max_motion_px,
                              .reference = setup.reference},
      std::move(opengl));
}

std::vector<BehaviourProcess> render_processes(int count, const std::string& address,
                                               const std::string& token) {
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "seam-render";
  if (!std::filesystem::exists(program))
    throw InputError(fmt::format("{}: no such program, which --renderers needs", program.string()));
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const int threads = std::max(1, cores / count);
  std::vector<BehaviourProcess> processes;
  for (int i = 1; i <= count; ++i)
    processes.push_back({fmt::format("renderer-{}", i),
                         {program.string(), "--name", fmt::format("renderer-{}", i), "--threads",
                          std::to_string(threads)},
                         {{"SEAM_ADDRESS", address}, {"SEAM_RENDER_TOKEN", token}}});
  return processes;
}

void add_remote_rendering_options(Command command, RemoteRenderingOptions& options) {
  command
      .add_option("--renderers", options.renderers,
                  "Frames are made by so many `seam-render` processes; the clock starts when\n"
                  "they are there. 0: by the server")
      .range(0, 64);
  command
      .add_option("--renderer-limit", options.frames.limit_s,
                  "Wall-clock seconds for one frame; a slower renderer is dropped")
      .range(0.01, 1e6)
      .show_default();
  command
      .add_option("--renderer-check", options.frames.check_every,
                  "One in so many frames of each renderer is rendered by the server too and\n"
                  "compared; 0: none")
      .show_default();
  command
      .add_option("--renderer-policy", options.policy,
                  "Where no renderer can make a frame: `fallback`, the server makes it, or\n"
                  "`abort`, the run ends with an error")
      .one_of({"fallback", "abort"})
      .show_default();
}

}  // namespace seam::app
