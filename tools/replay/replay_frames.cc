// `seam replay frames F --robot R --out DIR`: what a robot saw, at any time, with any model.
#include <cstdio>
#include <filesystem>

#include "app/logs/replay_match.h"
#include "app/session/frame_files.h"
#include "app/session/run_session.h"
#include "scheduler/replay/frame_maker.h"
#include "sim_core/base/error.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct FramesSettings {
  std::string file;
  std::string robot;
  std::string out;
  double from_s = 0;
  std::optional<double> to_s;
  app::ReplayOptions replay;
  bool force = false;
};

void write_frames(const FramesSettings& settings) {
  const scheduler::Log log = scheduler::Log::open(settings.file);
  app::ReplayMatch match(log, settings.replay);
  const int robot = match.robot(settings.robot);
  const SimTime from = SimTime::from_s(settings.from_s);
  const SimTime to = settings.to_s ? SimTime::from_s(*settings.to_s) : log.end_time();
  if (to < from) throw UsageError("--to: expected a time that is not before --from");
  app::FrameFiles files(settings.out, settings.force);
  uint64_t frames = 0;
  scheduler::make_frames(match.rewinder(), match.renderer(), robot, from, to,
                         [&](const scheduler::FinishedFrame& frame) {
                           files.on_frame(frame.time, *frame.job, *frame.frame);
                           ++frames;
                         });
  files.on_end(to, scheduler::EndReason::finished, 0);
  std::printf("%s: %llu frames of %s\n", settings.out.c_str(),
              static_cast<unsigned long long>(frames), settings.robot.c_str());
}

}  // namespace

void add_replay_frames(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "frames",
      "Renders every frame of a robot's camera clock, also those that the run did not ask "
      "for");
  auto settings = std::make_shared<FramesSettings>();
  command.add_option("F", settings->file, "The log").required();
  command.add_option("--robot", settings->robot, "Whose camera").required();
  command.add_option("--out", settings->out, "Folder for ROBOT_NNNNNN.png and frames.csv")
      .required();
  command.add_option("--from", settings->from_s, "Simulated seconds: the first stamp")
      .range(0.0, 9e9);
  command.add_option("--to", settings->to_s, "Simulated seconds: the last stamp (the log's end)")
      .range(0.0, 9e9);
  command.add_option("--model", settings->replay.models,
                     "[ROBOT=]FILE: another camera model than the run's");
  app::add_drawing_options(command, settings->replay.drawing, settings->replay.gl, "as the run's");
  command.add_flag("--force", settings->force, "Replaces the frames that the folder holds");
  command.footer(
      "Example: seam replay frames match.mcap --robot red1 --from 10 --to 12 --out eyes");
  command.callback([settings] { write_frames(*settings); });
}

}  // namespace seam::tools
