#include "app/run_session.h"

#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "app/behaviours.h"
#include "app/frame_files.h"
#include "app/progress.h"
#include "mcap/io.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"

namespace seam::app {

namespace {

// 128 random bits from the operating system: a secret, and never part of the simulation.
std::string new_token() {
  uint64_t words[2];
  if (getentropy(words, sizeof words) != 0) throw InputError("no random numbers for tokens");
  return to_hex(words[0]) + to_hex(words[1]);
}

// A folder for the private socket, readable by this user alone, gone with this object.
class SocketFolder {
 public:
  SocketFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "seam-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr)
      throw InputError(fmt::format("{}: cannot make a folder for the socket", pattern));
    path_ = pattern;
  }
  ~SocketFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string address() const { return "unix:" + (path_ / "socket").string(); }

 private:
  std::filesystem::path path_;
};

std::optional<scheduler::TlsTexts> read_certificates(const std::string& folder) {
  if (folder.empty()) return std::nullopt;
  const std::filesystem::path path = folder;
  return scheduler::TlsTexts{read_file(path / "ca.pem"), read_file(path / "server.pem"),
                             read_file(path / "server.key")};
}

// Notes why a run was aborted.
class AbortReason final : public scheduler::SimulationObserver {
 public:
  void on_event(const scheduler::SimulationEvent& event) override {
    if (event.kind != scheduler::EventKind::policy) return;
    const std::string line = fmt::format("{}: {} at {:.3f} s: {}", event.robot, event.name,
                                         event.time.s(), event.detail);
    if (event.name == "abort") text = line;
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  std::string text;
};

void write_tokens(const std::string& file, const std::vector<scheduler::HubRobot>& robots,
                  const std::string& supervisor, const std::string& render) {
  std::string text = fmt::format("supervisor: {}\nrender: {}\nrobots:\n", supervisor, render);
  for (const scheduler::HubRobot& robot : robots)
    text += fmt::format("  {}: {}\n", robot.id, robot.token);
  write_file_atomically(file, text);
  chmod(file.c_str(), S_IRUSR | S_IWUSR);
}

std::vector<std::string> command_of(const RobotSpec& robot, const SessionOptions& options) {
  const auto replaced = options.commands.find(robot.id);
  return replaced == options.commands.end() ? robot.behaviour.command : replaced->second;
}

std::vector<scheduler::HubRobot> hub_robots(const Scenario& scenario,
                                            const SessionOptions& options) {
  std::vector<scheduler::HubRobot> robots;
  for (const RobotSpec& robot : scenario.robots)
    robots.push_back(
        {.id = robot.id,
         .token = robot.token.empty() ? new_token() : robot.token,
         .policy = robot.behaviour.silence,
         .limit_s = robot.behaviour.wall_limit.s(),
         .connect_limit_s = options.start_behaviours ? 60 : 1e9,
         // Nobody will come for a robot without a behaviour that `run` could start.
         .expected = !options.start_behaviours || !command_of(robot, options).empty()});
  return robots;
}

std::vector<BehaviourProcess> behaviour_processes(const Scenario& scenario,
                                                  const SessionOptions& options) {
  std::vector<BehaviourProcess> processes;
  if (!options.start_behaviours) return processes;
  for (const RobotSpec& robot : scenario.robots) {
    std::vector<std::string> command = command_of(robot, options);
    if (command.empty()) continue;
    command[0] = find_behaviour(command[0], robot.id);
    processes.push_back({robot.id, std::move(command), {}});
  }
  return processes;
}

void wait_for_renderers(const scheduler::RemoteRenderer& remote,
                        const RemoteRenderingOptions& options, const scheduler::RunControl& control,
                        const std::atomic<bool>& one_ended) {
  const auto wanted = static_cast<size_t>(options.renderers);
  if (remote.wait_for(wanted, options.connect_limit_s,
                      [&] { return control.stop_requested() || one_ended; }) ||
      control.stop_requested())
    return;
  throw InputError(one_ended ? std::string("a renderer ended before the run began")
                             : fmt::format("{} of {} renderers came within {} s",
                                           remote.renderers(), wanted, options.connect_limit_s));
}

}  // namespace

SessionSummary run_session(Simulator& simulator, const SessionOptions& options,
                           const WrapSource& wrap,
                           std::vector<scheduler::SimulationObserver*> observers) {
  block_signals();
  const Scenario& scenario = simulator.scenario;
  std::vector<BehaviourProcess> processes = behaviour_processes(scenario, options);
  std::vector<scheduler::HubRobot> robots = hub_robots(scenario, options);

  // What the run writes is opened first: a bad path is found before anything starts.
  std::optional<FrameFiles> frames;
  if (!options.frames.empty()) frames.emplace(options.frames);
  std::unique_ptr<mcap::Output> log;
  std::optional<scheduler::Recorder> recorder;
  if (!options.log.empty()) {
    log = mcap::create_file(options.log);
    recorder.emplace(*log, simulator.world, options.recording);
  }
  AbortReason aborted;
  observers.push_back(&aborted);
  MemoryWatch memory;
  observers.push_back(&memory);
  if (recorder) observers.push_back(&*recorder);
  if (frames) observers.push_back(&*frames);

  scheduler::RunControl control;
  scheduler::ClientHub hub(robots, control);
  const SocketFolder socket;
  RemoteRenderingOptions rendering = options.rendering;
  rendering.frames.token = scenario.render_token.empty() ? new_token() : scenario.render_token;
  std::unique_ptr<scheduler::RemoteRenderer> remote;
  if (rendering.renderers > 0)
    remote = make_remote_renderer(simulator, rendering, [&hub](int robot, const std::string& what) {
      hub.note_fault(robot, "renderer", what);
      std::fprintf(stderr, "%s\n", what.c_str());
    });
  scheduler::ServerOptions serving{.addresses = options.addresses,
                                   .tls = read_certificates(options.certificates),
                                   .supervisor_token = scenario.supervisor_token,
                                   .renderers = remote.get()};
  if (serving.supervisor_token.empty()) serving.supervisor_token = new_token();
  if (options.start_behaviours) serving.addresses.push_back(socket.address());
  const scheduler::Server server(serving, scenario, simulator.world, hub, control);
  if (!options.token_file.empty())
    write_tokens(options.token_file, robots, serving.supervisor_token, rendering.frames.token);
  for (const std::string& address : server.addresses())
    if (address != socket.address()) std::printf("listening on %s\n", address.c_str());
  std::fflush(stdout);

  // Whatever ends the run, also an error of an observer (a full disk): calls that wait for the loop
  // are answered before the server goes.
  const struct Closer {
    scheduler::RunControl& control;
    ~Closer() { control.close(); }
  } closer{control};

  Behaviours renderers;
  if (remote && options.start_behaviours)
    for (const BehaviourProcess& process :
         render_processes(rendering.renderers, socket.address(), rendering.frames.token))
      renderers.start(process);
  Behaviours behaviours;
  for (BehaviourProcess& process : processes) {
    const auto& robot = robots[static_cast<size_t>(hub.robot_number(process.robot))];
    process.environment = {
        {"SEAM_ADDRESS", socket.address()}, {"SEAM_ROBOT", robot.id}, {"SEAM_TOKEN", robot.token}};
    behaviours.start(process);
  }

  SessionSummary summary;
  {
    std::atomic<bool> renderer_ended = false;
    const SignalWatch signals(
        [&] { control.stop(); },
        [&] {
          renderers.reap([&](const std::string& name, const std::string& how) {
            if (how != "ended with exit code 0")
              std::fprintf(stderr, "%s %s\n", name.c_str(), how.c_str());
            renderer_ended = true;
          });
          behaviours.reap([&](const std::string& robot, const std::string& how) {
            hub.give_up(robot, "its behaviour " + how);
          });
        });
    if (remote) wait_for_renderers(*remote, rendering, control, renderer_ended);
    const Progress progress(hub, control, scenario.duration);
    const auto source = wrap ? wrap(hub) : nullptr;
    scheduler::DecisionSource& decisions = source ? *source : hub;
    scheduler::Simulation simulation(
        {scenario, simulator.world, decisions, control,
         remote ? static_cast<scheduler::FrameRenderer*>(remote.get()) : simulator.renderer.get(),
         observers, simulator.header},
        {.camera_at_rows = frames.has_value()});
    // Also on the way out of an error: threads that wait for a frame go on.
    const struct Finisher {
      scheduler::RemoteRenderer* remote;
      ~Finisher() {
        if (remote != nullptr) remote->finish("the run is over");
      }
    } finisher{remote.get()};
    const auto start = std::chrono::steady_clock::now();
    summary.end = simulation.run();
    summary.wall_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    summary.sim_s = simulation.now().s();
    summary.frames = simulation.frames();
    summary.rendered_remotely = remote ? remote->rendered_remotely() : 0;
    summary.decisions = simulation.decisions();
    summary.fingerprint = simulation.fingerprint();
    summary.waiting_s = hub.wall_waiting_s();
    summary.abort_reason = aborted.text;
    summary.has_score = scenario.referee.enabled;
    summary.red_score = simulator.world.score(Team::red);
    summary.blue_score = simulator.world.score(Team::blue);
    summary.memory = memory.samples();
  }
  behaviours.wait_for_end(2);
  renderers.wait_for_end(2);
  std::error_code unknown;
  if (log) summary.log_bytes = std::filesystem::file_size(options.log, unknown);
  if (unknown) summary.log_bytes = 0;
  return summary;
}

int report(const SessionSummary& summary, const SessionOptions& options) {
  const char* ends[] = {"finished", "stopped", "aborted"};
  const char* end = ends[static_cast<size_t>(summary.end)];
  std::printf(
      "%s: %.3f simulated seconds in %.3f s, %.2f x real time; %llu frames, %llu decisions\n"
      "fingerprint %s\n",
      end, summary.sim_s, summary.wall_s, summary.real_time_factor(),
      static_cast<unsigned long long>(summary.frames),
      static_cast<unsigned long long>(summary.decisions), to_hex(summary.fingerprint).c_str());
  std::string score;
  if (summary.has_score) {
    std::printf("score red %d, blue %d\n", summary.red_score, summary.blue_score);
    score = fmt::format(",\n  \"score\": {{\"red\": {}, \"blue\": {}}}", summary.red_score,
                        summary.blue_score);
  }
  std::string memory;
  for (const MemorySample& sample : summary.memory)
    memory += fmt::format("{}\n    {{\"sim_s\": {}, \"rss_bytes\": {}}}", memory.empty() ? "" : ",",
                          sample.sim_s, sample.resident_bytes);
  if (!options.json.empty())
    write_file_atomically(
        options.json,
        fmt::format("{{\n  \"format\": \"seam-run/1\",\n  \"sim_s\": {},\n  \"wall_s\": {},\n"
                    "  \"real_time_factor\": {},\n  \"frames\": {},\n  \"fingerprint\": \"{}\",\n"
                    "  \"rendered_remotely\": {},\n  \"decisions\": {},\n  \"waiting_s\": {},\n  "
                    "\"end\": \"{}\"{},\n"
                    "  \"log_bytes\": {},\n  \"memory\": [{}]\n}}\n",
                    summary.sim_s, summary.wall_s, summary.real_time_factor(), summary.frames,
                    to_hex(summary.fingerprint), summary.rendered_remotely, summary.decisions,
                    summary.waiting_s, end, score, summary.log_bytes, memory));
  if (summary.end != scheduler::EndReason::aborted) return 0;
  std::fprintf(stderr, "seam: the run was aborted: %s\n", summary.abort_reason.c_str());
  return 1;
}

void add_session_options(Command command, SessionOptions& session, SimulatorOptions& simulator) {
  command.add_option("--seed", simulator.seed, "Replaces the scenario's seed");
  command.add_option("--log", session.log, "Writes the replay log (MCAP) here");
  command.add_flag("--log-frames", session.recording.pictures,
                   "The log also holds each frame as a picture (foxglove.CompressedImage)");
  command.add_flag(
      "--log-poses", [&session] { session.recording.transforms = session.recording.scene = true; },
      "The log also holds poses and the scene for other MCAP tools (foxglove.FrameTransforms,\n"
      "foxglove.SceneUpdate)");
  command.add_option("--frames", session.frames,
                     "Writes each frame as ROBOT_NNNNNN.png and frames.csv into this folder");
  command.add_option("--json", session.json, "Writes the summary here");
  command.add_option("--model", simulator.models,
                     "[ROBOT=]FILE: a seam-model/1 file in place of the scenario's");
  command
      .add_option("--render-threads", simulator.render_workers,
                  "Frames made at once; 0 is one for each core")
      .range(0, 64);
  add_remote_rendering_options(command, session.rendering);
}

}  // namespace seam::app
