// `seam frame SCENARIO --robot R --at T --out F`: one frame, every stage of its chain, ground
// truth.
#include <cstdio>
#include <filesystem>
#include <limits>

#include "app/session/run_session.h"
#include "app/session/scenario_frames.h"
#include "render/colour/colour_detector.h"
#include "render/pictures/pictures.h"
#include "sim_core/base/error.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"
#include "tools/command.h"

namespace seam::tools {
namespace {

struct FrameSettings {
  std::string scenario;
  std::string robot;
  double at_s = 0;
  std::string out;
  std::string stages;
  std::string table;
  app::SimulatorOptions simulator;
};

// The given table, else the field's own beside the scenario, else one made from this frame's
// labels.
render::ColourTable table_for(const FrameSettings& settings, const Frame& frame,
                              const render::GroundTruth& truth) {
  if (!settings.table.empty()) return render::ColourTable::from_file(settings.table);
  const auto beside =
      std::filesystem::path(settings.scenario).parent_path() / "../models/colour_table_2002.yaml";
  if (std::filesystem::exists(beside)) return render::ColourTable::from_file(beside);
  render::ColourTableMaker maker;
  maker.add(frame.ycrcb, truth.label, frame.width_px, frame.height_px);
  return maker.table();
}

double longest_flow(const render::GroundTruth& truth) {
  double longest = 0.5;
  for (size_t i = 0; i < truth.flow_u_px.size(); ++i) {
    longest = std::max<double>(
        longest, std::max(std::abs(truth.flow_u_px[i]), std::abs(truth.flow_v_px[i])));
  }
  return longest;
}

// Writes DIR/NN_name.png for each stage and kind of ground truth, and DIR/contact_sheet.png.
void write_stages(const FrameSettings& settings, const FrameJob& job, const Frame& frame,
                  const render::Renderer& camera) {
  const render::GroundTruth truth = camera.ground_truth(job);
  std::vector<render::Panel> panels;
  for (const render::StageImage& stage : camera.stages(job))
    panels.push_back({stage.name, render::picture_of(stage.image)});
  const render::Detections seen = render::ColourDetector(table_for(settings, frame, truth))
                                      .detect(frame.ycrcb, frame.width_px, frame.height_px);
  panels.push_back(
      {"colours", render::picture_of_detections(seen.bits, seen.width_px, seen.height_px)});
  panels.push_back({"labels", render::picture_of_labels(truth)});
  panels.push_back({"depth", render::picture_of_depth(truth)});
  panels.push_back({"motion", render::picture_of_flow(truth, longest_flow(truth))});
  for (size_t i = 0; i < panels.size(); ++i) {
    write_png(
        std::filesystem::path(settings.stages) / fmt::format("{:02}_{}.png", i, panels[i].caption),
        panels[i].image);
    panels[i].image = render::enlarged(panels[i].image, panels[i].caption == "colours" ? 4 : 2);
  }
  panels.back().caption =
      fmt::format("motion in the exposure, up to {:.1f} px", longest_flow(truth));
  write_png(std::filesystem::path(settings.stages) / "contact_sheet.png",
            render::contact_sheet(panels, 3));
}

void render_frame(const FrameSettings& settings) {
  OutputRules rules{.inputs = {settings.scenario}};
  for (const std::string& model : settings.simulator.models)
    rules.inputs.emplace_back(model.substr(model.find('=') + 1));  // Of ROBOT=FILE, or all of FILE.
  OutputFile out(settings.out, rules);
  if (!settings.stages.empty()) make_output_folder(settings.stages);
  app::visit_first_frame(
      settings.scenario, settings.simulator, settings.robot, SimTime::from_s(settings.at_s),
      [&](const scheduler::FinishedFrame& finished, const render::Renderer& camera) {
        const Frame& frame = *finished.frame;
        out.fill(encode_png(render::picture_of_frame(frame)));
        if (!settings.stages.empty()) write_stages(settings, *finished.job, frame, camera);
        std::printf("%s: frame %llu of %s, stamp %.6f s, fingerprint %s\n", settings.out.c_str(),
                    static_cast<unsigned long long>(frame.frame_index), settings.robot.c_str(),
                    frame.stamp.s(), to_hex(frame.fingerprint).c_str());
      });
}

}  // namespace

void add_frame(app::Command app) {
  app::Command command =
      app.add_subcommand("frame", "One frame of a robot's camera, with every stage of its making");
  auto settings = std::make_shared<FrameSettings>();
  command.add_option("SCENARIO", settings->scenario, "A seam-scenario/1 file").required();
  command.add_option("--robot", settings->robot, "Whose camera").required();
  command
      .add_option("--at", settings->at_s,
                  "Simulated seconds: the first frame of the camera's clock from then on")
      .required()
      .range(0.0, 1e6);
  command.add_option("--out", settings->out, "The frame, a PNG file").required();
  command.add_option("--stages", settings->stages,
                     "Folder for the stages, the ground truth and a contact sheet");
  command.add_option("--colour-table", settings->table,
                     "A seam-colour-table/1 file for the colour stage");
  command.add_option("--model", settings->simulator.models,
                     "[ROBOT=]FILE: another camera model than the scenario's");
  app::add_drawing_options(command, settings->simulator.drawing, settings->simulator.gl);
  command.add_option("--seed", settings->simulator.seed, "Another seed than the scenario's");
  command.footer(
      "Example: seam frame scenarios/head_swing.yaml --robot red1 --at 0.5 --stages stages --out "
      "frame.png");
  command.callback([settings] { render_frame(*settings); });
}

}  // namespace seam::tools
