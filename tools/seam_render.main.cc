// `seam-render`: makes frames of a run on another machine than the server's
// (docs/reference/server.md).
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "app/command_line.h"
#include "app/plugins.h"
#include "app/session/remote_rendering.h"
#include "scheduler/remote_render/render_client.h"
#include "seam_built_from.h"
#include "tools/program.h"

namespace {

std::string host_and_process() {
  char host[64] = "";
  gethostname(host, sizeof host - 1);
  return fmt::format("{}:{}", host, getpid());
}

void add_options(seam::app::Command app, seam::scheduler::RenderClientOptions& options) {
  app.add_option("--address", options.address, "The server's: host:port or unix:/path")
      .environment("SEAM_ADDRESS")
      .required();
  app.add_option(
         "--token", options.token,
         "The render token (`render` in the file of `seam serve --tokens`); better given by the\n"
         "environment, which other users of the machine cannot read")
      .environment("SEAM_RENDER_TOKEN")
      .required();
  app.add_option("--certs", options.certificates,
                 "Folder with ca.pem, client.pem, client.key, where the server asks for TLS")
      .environment("SEAM_CERTS");
  app.add_option(
      "--robot", options.robots,
      "Renders this robot's frames alone; may be given several times. Left out: all frames");
  app.add_option("--threads", options.threads, "Frames rendered at once; 0 is one for each core")
      .range(0, 32);
  app.add_option("--name", options.name, "How the server's messages call this process")
      .show_default();
  app.footer(
      "Also --plugin FILE, for each that the server has.\n"
      "Example:\n  SEAM_RENDER_TOKEN=$(sed -n 's/^render: //p' tokens.yaml) \\\n"
      "    seam-render --address 127.0.0.1:7210 --robot red1\n"
      "Exit code 0 when the run is over, 1 when the server refuses or is gone, 2 for wrong use.");
  app.callback([&options] {
    if (options.threads == 0)
      options.threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 32);
    seam::scheduler::render_for_server(
        options, [&options](const seam::scheduler::RenderSetup& setup) {
          return seam::app::make_told_renderer(setup, options.threads);
        });
  });
}

}  // namespace

int main(int argc, char** argv) {
  seam::scheduler::RenderClientOptions options;
  options.version = SEAM_VERSION;
  options.name = host_and_process();
  options.threads = 0;
  return seam::tools::run_program("seam-render", [&] {
    return seam::app::parse_and_run(
        "Renders frames of a run on this machine, the same bits as in the server", "seam-render",
        "seam-render " SEAM_BUILT_FROM, seam::app::load_plugins({argv + 1, argv + argc}),
        [&](seam::app::Command app) { add_options(app, options); });
  });
}
