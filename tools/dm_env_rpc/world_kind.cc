#include "tools/dm_env_rpc/world_kind.h"

#include <fstream>

#include "app/session/behaviours.h"
#include "sim_core/base/error.h"
#include "sim_core/system/own_files.h"

namespace seam::tools::dm {

namespace {

// Of this process, as it was started: plugins are loaded before commands are read.
std::vector<std::string> plugin_words() {
  std::ifstream line("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(line, word, '\0');) {
    if (word.starts_with("--plugin=")) words.push_back(word);
    if (word != "--plugin") continue;
    words.push_back(word);
    if (std::getline(line, word, '\0')) words.push_back(word);
  }
  return words;
}

void refuse_options_of_one_run(const app::SessionOptions& session) {
  const auto refuse = [](bool given, const char* option, const char* instead) {
    if (given)
      throw UsageError(std::string(option) +
                       ": expected without --dm-env-rpc, which makes many "
                       "runs" +
                       instead);
  };
  refuse(!session.log.empty(), "--log", ": --logs FOLDER takes their logs");
  refuse(!session.sign_key.empty(), "--sign", "");
  refuse(!session.frames.empty(), "--frames", ": `seam replay frames` makes them from a log");
  refuse(!session.json.empty(), "--json", "");
  refuse(!session.token_file.empty(), "--tokens", "; a robot's token is the scenario's");
  refuse(!session.lines.empty(), "--lines", "");
  refuse(session.rendering.renderers > 0, "--renderers", "");
}

std::vector<std::string> words_of(const std::string& scenario, const app::SessionOptions& session,
                                  const app::SimulatorOptions& simulator) {
  std::vector<std::string> words = {program_file().string()};
  const auto add = [&](const char* option, const std::string& value) {
    words.emplace_back(option);
    words.push_back(value);
  };
  for (const std::string& word : plugin_words()) words.push_back(word);
  words.insert(words.end(), {"serve", scenario});
  for (const std::string& change : simulator.changes) add("--set", change);
  for (const std::string& model : simulator.models) add("--model", model);
  for (const std::string& robot : session.driven) add("--drive", robot);
  add("--renderer", simulator.drawing);
  add("--gl", simulator.gl);
  add("--render-threads", std::to_string(simulator.render_workers));
  if (session.force) words.emplace_back("--force");
  if (session.durable) words.emplace_back("--durable");
  if (session.recording.pictures) words.emplace_back("--log-frames");
  if (session.recording.scene) words.emplace_back("--log-poses");
  return words;
}

void make_log_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(fmt::format("{}: cannot be made: {}", folder, error.message()));
}

}  // namespace

WorldKind make_world_kind(const std::string& scenario, const app::SessionOptions& session,
                          const app::SimulatorOptions& simulator, const LearningOptions& learning) {
  refuse_options_of_one_run(session);
  const Scenario read = app::load_scenario(scenario, simulator);
  app::require_driven_robots(session.driven, read);
  app::SessionOptions with_robots = session;
  if (with_robots.driven.empty()) with_robots.driven = {"*"};
  WorldKind kind{.scenario = read.name,
                 .seed = read.seed,
                 .duration_s = read.duration.s(),
                 .robots = {},
                 .command = {words_of(scenario, with_robots, simulator), learning.logs},
                 .most_worlds = static_cast<size_t>(learning.worlds)};
  for (const RobotSpec& robot : read.robots)
    if (app::is_driven(with_robots.driven, robot.id)) kind.robots.emplace_back(read, robot);
  if (!learning.logs.empty()) make_log_folder(learning.logs);
  return kind;
}

}  // namespace seam::tools::dm
