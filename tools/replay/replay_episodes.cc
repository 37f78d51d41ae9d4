// `seam replay episodes LOG... --out DIR`: recorded runs as data for learning.
#include <cstdio>
#include <filesystem>

#include "app/episodes/episode.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shown_text.h"
#include "tools/command.h"
#include "tools/replay/replay.h"

namespace seam::tools {
namespace {

struct EpisodeSettings {
  std::vector<std::string> logs;
  std::string robot, out;
  bool frames = false;
};

void write_episodes(const EpisodeSettings& settings) {
  app::EpisodeFolder folder(settings.out);
  for (const std::string& file : settings.logs) {
    const scheduler::Log log = scheduler::Log::open(file);
    folder.add(app::episode_of(log, settings.robot, settings.frames),
               std::filesystem::path(file).filename().string());
  }
  folder.finish();
  std::printf("%s: %zu episodes, %zu rows; schema.json says what is what\n",
              shown(settings.out).c_str(), folder.episodes(), folder.rows());
}

}  // namespace

void add_replay_episodes(app::Command replay) {
  app::Command command = replay.add_subcommand(
      "episodes", "Writes what a robot sensed and ordered as data for learning (NPZ)");
  auto settings = std::make_shared<EpisodeSettings>();
  command.add_option("LOG", settings->logs, "The logs, each an episode").required();
  command.add_option("--out", settings->out, "Folder to write to: a file an episode, schema.json")
      .required();
  command.add_option("--robot", settings->robot, "The robot; left out: the only one of the log");
  command.add_flag("--frames", settings->frames,
                   "With the frames that the robot was sent; those that the log does not hold are\n"
                   "drawn again");
  command.footer("Example: seam replay episodes match.mcap --robot red1 --out episodes");
  command.callback([settings] { write_episodes(*settings); });
}

}  // namespace seam::tools
