// `seam colour-table SCENARIO --robot R --out F`: a colour detection table from labelled frames.
#include "render/colour/colour_table.h"

#include <cstdio>

#include "app/session/scenario_frames.h"
#include "sim_core/base/error.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {

void add_colour_table(app::Command app) {
  struct Settings {
    std::string scenario;
    std::string robot;
    std::string out;
    double from_s = 0;
    double to_s = 1;
    double outliers = 0.005;
    app::SimulatorOptions simulator;
  };
  app::Command command = app.add_subcommand(
      "colour-table", "Makes a colour detection table from frames whose labels are known");
  auto settings = std::make_shared<Settings>();
  command.add_option("SCENARIO", settings->scenario, "A seam-scenario/1 file").required();
  command.add_option("--robot", settings->robot, "Whose camera looks").required();
  command.add_option("--out", settings->out, "The seam-colour-table/1 file to write").required();
  command.add_option("--from", settings->from_s, "Simulated seconds: the first frame")
      .range(0.0, 1e6);
  command.add_option("--to", settings->to_s, "Simulated seconds: the last frame").range(0.0, 1e6);
  command
      .add_option("--outliers", settings->outliers,
                  "Part of a colour's pixels left outside on each side")
      .range(0.0, 0.2);
  command.add_option("--model", settings->simulator.models,
                     "[ROBOT=]FILE: another camera model than the scenario's");
  command.footer(
      "Example: seam colour-table scenarios/head_swing.yaml --robot red1 --to 2 --out table.yaml");
  command.callback([settings] {
    if (settings->to_s < settings->from_s)
      throw UsageError("--to: expected a time that is not before --from");
    OutputFile out(settings->out, {.inputs = {settings->scenario}});
    render::ColourTableMaker maker;
    int frames = 0;
    app::visit_scenario_frames(
        settings->scenario, settings->simulator, settings->robot, SimTime::from_s(settings->from_s),
        SimTime::from_s(settings->to_s),
        [&](const scheduler::FinishedFrame& finished, const render::Renderer& camera) {
          const Frame& frame = *finished.frame;
          maker.add(frame.ycrcb, camera.ground_truth(*finished.job).label, frame.width_px,
                    frame.height_px);
          ++frames;
        });
    out.fill(maker.table(settings->outliers).to_yaml());
    std::printf("%s: made from %d frames of %s\n", settings->out.c_str(), frames,
                settings->robot.c_str());
  });
}

}  // namespace seam::tools
