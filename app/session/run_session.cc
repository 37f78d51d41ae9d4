#include "app/session/run_session.h"

#include <fmt/ranges.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "app/scratch_folder.h"
#include "app/session/behaviours.h"
#include "app/session/printed_output.h"
#include "app/session/progress.h"
#include "app/session/session_outputs.h"
#include "app/signals/live_watches.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/base/hash.h"
#include "sim_core/base/output.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/system/resources.h"

namespace seam::app {

namespace {

// 128 random bits of the operating system: a secret, never part of the simulation.
std::string new_token() {
  uint64_t words[2];
  if (getentropy(words, sizeof words) != 0) throw InputError("no random numbers for tokens");
  return to_hex(words[0]) + to_hex(words[1]);
}

// Notes why a run was aborted, and shows warnings as they come.
class AbortReason final : public scheduler::SimulationObserver {
 public:
  explicit AbortReason(bool with_clamped) : shows_clamped(with_clamped) {}
  void on_event(const scheduler::SimulationEvent& event) override {
    if (shows_clamped && event.kind == scheduler::EventKind::fault &&
        event.name == scheduler::kClampedFault)
      show_line(scheduler::clamped_line(event));
    if (event.kind != scheduler::EventKind::policy) return;
    const std::string line = fmt::format("{}: {} at {:.3f} s: {}", event.robot, event.name,
                                         event.time.s(), event.detail);
    if (event.name == "abort") text = line;
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  std::string text;
  const bool shows_clamped;
};

std::vector<std::string> command_of(const RobotSpec& robot, const SessionOptions& options) {
  const auto replaced = options.commands.find(robot.id);
  return replaced == options.commands.end() ? robot.behaviour.command : replaced->second;
}

std::vector<scheduler::HubRobot> hub_robots(const Scenario& scenario,
                                            const SessionOptions& options) {
  std::vector<scheduler::HubRobot> robots;
  const auto driven = [&](const RobotSpec& robot) {
    return robot.id == options.by_hand.robot || is_driven(options.driven, robot.id);
  };
  for (const RobotSpec& robot : scenario.robots)
    robots.push_back(
        {.id = robot.id,
         .token = robot.token.empty() ? new_token() : robot.token,
         // A program that stands in a debugger is silent for as long as its user thinks.
         .policy = driven(robot) ? SilencePolicy::wait : robot.behaviour.silence,
         .limit_s = robot.behaviour.wall_limit.s(),
         .connect_limit_s = options.start_behaviours && !driven(robot) ? 60 : 1e9,
         // Nobody will come for a robot without a behaviour that `run` could start.
         .expected =
             !options.start_behaviours || driven(robot) || !command_of(robot, options).empty()});
  return robots;
}

std::vector<BehaviourProcess> behaviour_processes(const Scenario& scenario,
                                                  const SessionOptions& options) {
  std::vector<BehaviourProcess> processes;
  if (!options.start_behaviours) return processes;
  for (const RobotSpec& robot : scenario.robots) {
    std::vector<std::string> command = command_of(robot, options);
    if (command.empty() || is_driven(options.driven, robot.id)) continue;
    command[0] = find_behaviour(command[0], robot.id);
    processes.push_back({robot.id, std::move(command), behaviour_environment()});
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

// Whatever ends the run, also an error of an observer (a full disk): calls that wait for the loop
// are answered before the server goes.
struct Closer {
  scheduler::RunControl& control;
  ~Closer() { control.close(); }
};

// Also on the way out of an error: threads that wait for a frame go on.
struct Finisher {
  scheduler::RemoteRenderer* remote;
  ~Finisher() {
    if (remote != nullptr) remote->finish("the run is over");
  }
};

// The parts of one run, which end in the reverse order.
class Session {
 public:
  Session(Simulator& simulator, const SessionOptions& options, SessionOutputs& outputs)
      : simulator_(simulator),
        options_(options),
        outputs_(outputs),
        processes_(behaviour_processes(simulator.scenario, options)),
        robots_(hub_robots(simulator.scenario, options)),
        hub_(robots_, control_) {
    if (outputs.log) recorder_.emplace(*outputs.log, simulator.world, options.recording);
  }

  SessionSummary run(const WrapSource& wrap,
                     std::vector<scheduler::SimulationObserver*> observers) {
    serve();
    start_processes();
    Printing printing(printed_, recorder_ ? &*recorder_ : nullptr);
    observers.push_back(&printing);
    observers.push_back(&aborted_);
    observers.push_back(&notes_);
    observers.push_back(&logged_);
    observers.push_back(&memory_);
    observers.push_back(&watches_);
    if (recorder_) observers.push_back(&*recorder_);
    if (outputs_.frames) observers.push_back(&*outputs_.frames);
    SessionSummary summary = simulate(wrap, std::move(observers));
    if (passed_limit_) {
      summary.end = scheduler::EndReason::aborted;
      summary.abort_reason = *passed_limit_;
    }
    behaviours_.wait_for_end(2);
    renderers_.wait_for_end(2);
    printed_.take(SimTime(), true);  // What programs print at their very end is shown, too.
    summary.last_lines = printed_.last_lines();
    if (!outputs_.log) return summary;
    outputs_.finish_log();
    std::error_code unknown;
    summary.log_bytes = std::filesystem::file_size(options_.log, unknown);
    if (unknown) summary.log_bytes = 0;
    if (outputs_.key) outputs_.key->sign(options_.log);
    return summary;
  }

 private:
  void serve();
  void start_processes();
  std::map<std::string, std::string> connection_of(const std::string& robot) const;
  SessionSummary simulate(const WrapSource& wrap,
                          std::vector<scheduler::SimulationObserver*> observers);
  void reap();
  void watch_limit();

  Simulator& simulator_;
  const SessionOptions& options_;
  SessionOutputs& outputs_;
  const BlockedSignals blocked_;
  std::vector<BehaviourProcess> processes_;
  const std::vector<scheduler::HubRobot> robots_;
  std::optional<scheduler::Recorder> recorder_;
  AbortReason aborted_{options_.show_printed};
  scheduler::CommandNotes notes_;
  LoggedValues logged_;
  MemoryWatch memory_;
  LiveWatches watches_{simulator_.world, [this](const std::string& robot) {
                         return is_driven(options_.driven, robot);
                       }};
  scheduler::RunControl control_;
  scheduler::ClientHub hub_;
  // Of the private socket, which this user alone reaches.
  const ScratchFolder socket_folder_{"run"};
  const std::string socket_ = "unix:" + (socket_folder_.path() / "socket").string();
  const std::string lines_ =
      options_.lines.empty() ? (socket_folder_.path() / "lines").string() : options_.lines;
  std::string render_token_;
  std::unique_ptr<scheduler::RemoteRenderer> remote_;
  std::optional<scheduler::Server> server_;
  const Closer closer_{control_};
  PrintedOutput printed_{[this] { return control_.time(); }, options_.show_printed};
  Behaviours renderers_;
  Behaviours behaviours_{options_.standbys};
  std::atomic<bool> renderer_ended_ = false;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::optional<std::string> passed_limit_;  // The watching thread's, until that has ended.
};

void Session::serve() {
  const Scenario& scenario = simulator_.scenario;
  // gRPC ends the process where it is refused one.
  const int robots = static_cast<int>(scenario.robots.size());
  require_resources(/*threads=*/16 + 2 * robots, /*files=*/24 + 4 * robots);
  RemoteRenderingOptions rendering = options_.rendering;
  render_token_ = scenario.render_token.empty() ? new_token() : scenario.render_token;
  rendering.frames.token = render_token_;
  if (rendering.renderers > 0)
    remote_ =
        make_remote_renderer(simulator_, rendering, [this](int robot, const std::string& what) {
          hub_.note_fault(robot, "renderer", what);
          std::fprintf(stderr, "%s\n", what.c_str());
        });
  scheduler::ServerOptions serving{.addresses = options_.addresses,
                                   .tls = read_certificates(options_.certificates),
                                   .supervisor_token = scenario.supervisor_token,
                                   .renderers = remote_.get(),
                                   .watches = &watches_};
  if (serving.supervisor_token.empty()) serving.supervisor_token = new_token();
  if (options_.start_behaviours) {
    serving.addresses.push_back(socket_);
    serving.lines = lines_;
  }
  server_.emplace(serving, scenario, simulator_.world, hub_, control_);
  outputs_.fill_tokens(robots_, serving.supervisor_token, render_token_);
  for (const std::string& address : server_->addresses())
    if (address != socket_) std::printf("listening on %s\n", address.c_str());
  std::fflush(stdout);
}

// What a client finds in its environment.
std::map<std::string, std::string> Session::connection_of(const std::string& robot) const {
  return {{"SEAM_ADDRESS", socket_},
          {"SEAM_LINE", lines_},
          {"SEAM_ROBOT", robot},
          {"SEAM_TOKEN", robots_[static_cast<size_t>(hub_.robot_number(robot))].token}};
}

void Session::start_processes() {
  if (remote_ && options_.start_behaviours)
    for (const BehaviourProcess& process :
         render_processes(options_.rendering.renderers, socket_, render_token_))
      renderers_.start(process);
  for (BehaviourProcess& process : processes_) {
    process.environment.merge(connection_of(process.robot));
    process.output = printed_.open(process.robot);
    behaviours_.start(process);
    close(std::exchange(process.output, -1));
  }
  printed_.start();
  if (options_.by_hand.robot.empty()) return;
  auto environment = behaviour_environment();
  environment.merge(connection_of(options_.by_hand.robot));
  outputs_.by_hand.fill(environment_lines(environment));
  show_line(fmt::format("{} waits for your program, which finds the server by {}",
                        options_.by_hand.robot, shown(options_.by_hand.file)));
}

// Ends a run that takes too long, and notes for whom it waited.
void Session::watch_limit() {
  if (!options_.wall_limit_s || passed_limit_) return;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  if (wall.count() < *options_.wall_limit_s) return;
  double since_s = 0;
  const auto waiting = hub_.waiting_for(since_s);
  passed_limit_ =
      fmt::format("the limit of {} s on the wall passed at {:.3f} s{}", *options_.wall_limit_s,
                  control_.time().s(),
                  waiting.empty() ? "" : fmt::format(", waiting for {}", fmt::join(waiting, ", ")));
  control_.stop();
}

void Session::reap() {
  watch_limit();
  if (options_.until_eof && input_has_ended()) control_.stop();
  renderers_.reap([&](const std::string& name, const std::string& how) {
    if (how != "ended with exit code 0") std::fprintf(stderr, "%s %s\n", name.c_str(), how.c_str());
    renderer_ended_ = true;
  });
  behaviours_.reap([&](const std::string& robot, const std::string& how) {
    hub_.give_up(robot, "its behaviour " + how);
  });
}

SessionSummary Session::simulate(const WrapSource& wrap,
                                 std::vector<scheduler::SimulationObserver*> observers) {
  const Scenario& scenario = simulator_.scenario;
  const SignalWatch signals([this] { control_.stop(); }, [this] { reap(); });
  if (remote_) wait_for_renderers(*remote_, options_.rendering, control_, renderer_ended_);
  std::optional<Progress> progress;
  if (options_.progress) progress.emplace(hub_, control_, scenario.duration);
  const auto source = wrap ? wrap(hub_) : nullptr;
  scheduler::DecisionSource& decisions = source ? *source : hub_;
  scheduler::FrameRenderer* renderer = simulator_.renderer.get();
  if (options_.renderer != nullptr) renderer = options_.renderer;
  if (remote_) renderer = remote_.get();
  const auto other = options_.wrap_renderer ? options_.wrap_renderer(*renderer) : nullptr;
  if (other) renderer = other.get();
  scheduler::Simulation simulation(
      {scenario, simulator_.world, decisions, control_, renderer, std::move(observers),
       simulator_.header},
      {.camera_at_rows = outputs_.frames.has_value(), .state_hashes = options_.state_hashes});
  const Finisher finisher{remote_.get()};
  const auto start = std::chrono::steady_clock::now();
  SessionSummary summary;
  summary.identity = identity_of(simulator_);
  summary.end = simulation.run();
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.sim_s = simulation.now().s();
  summary.frames = simulation.frames();
  summary.rendered_remotely = remote_ ? remote_->rendered_remotely() : 0;
  summary.decisions = simulation.decisions();
  summary.fingerprint = simulation.fingerprint();
  summary.waiting_s = hub_.wall_waiting_s();
  summary.abort_reason = aborted_.text;
  summary.logged = logged_.summaries();
  summary.refused = notes_.refused();
  summary.refused_lines = notes_.refused_lines();
  summary.clamped_lines = notes_.clamped_lines();
  summary.has_score = scenario.referee.enabled;
  summary.red_score = simulator_.world.score(Team::red);
  summary.blue_score = simulator_.world.score(Team::blue);
  summary.memory = memory_.samples();
  return summary;
}

}  // namespace

std::optional<scheduler::TlsTexts> read_certificates(const std::string& folder) {
  if (folder.empty()) return std::nullopt;
  const std::filesystem::path path = folder;
  return scheduler::TlsTexts{read_file(path / "ca.pem"), read_file(path / "server.pem"),
                             read_file(path / "server.key")};
}

SessionSummary run_session(Simulator& simulator, const SessionOptions& options,
                           SessionOutputs& outputs, const WrapSource& wrap,
                           std::vector<scheduler::SimulationObserver*> observers) {
  return Session(simulator, options, outputs).run(wrap, std::move(observers));
}

void add_drawing_options(Command command, std::string& drawing, std::string& gl,
                         const std::string& automatic) {
  command
      .add_option("--renderer", drawing,
                  "What makes frames: `analytic`, the ray caster of shapes; `opengl`, which also\n"
                  "draws meshes and textures; `auto`: " +
                      automatic)
      .one_of({"auto", "analytic", "opengl"})
      .show_default();
  command
      .add_option("--gl", gl,
                  "Where OpenGL comes from: `osmesa`, Mesa on the processor; `egl`, a graphics\n"
                  "processor's driver where there is one, else Mesa's; `auto`: osmesa, and egl\n"
                  "where that is not installed")
      .one_of({"auto", "osmesa", "egl"})
      .show_default();
}

void add_session_options(Command command, SessionOptions& session, SimulatorOptions& simulator) {
  command.add_option("--seed", simulator.seed, "Replaces the scenario's seed");
  command.add_option("--set", simulator.changes,
                     "PATH=VALUE: changes any key of the scenario or of a model that it names,\n"
                     "such as robots[0].camera.model.effects.EFFECT.PARAMETER=1e-4");
  command.add_option("--log", session.log, "Writes the replay log (MCAP) here");
  command.add_flag("--durable", session.durable,
                   "Syncs each chunk of the log to the disk: after a power cut what is older than\n"
                   "half a simulated second is there");
  command.add_option("--sign", session.sign_key,
                     "Signs the log, into a file LOG.sig beside it: a private key, Ed25519 in PEM");
  command.add_flag("--log-frames", session.recording.pictures,
                   "The log also holds each frame as a picture (foxglove.CompressedImage)");
  command.add_flag(
      "--log-poses", [&session] { session.recording.transforms = session.recording.scene = true; },
      "The log also holds poses and the scene for other MCAP tools (foxglove.FrameTransforms,\n"
      "foxglove.SceneUpdate)");
  command.add_option("--frames", session.frames,
                     "Writes each frame as ROBOT_NNNNNN.png and frames.csv into this folder");
  command.add_flag("--force", session.force, "Replaces a log and frames of an earlier run");
  command.add_option("--json", session.json, "Writes the summary here");
  command.add_option("--model", simulator.models,
                     "[ROBOT=]FILE: a seam-model/1 file in place of the scenario's");
  command
      .add_option("--render-threads", simulator.render_workers,
                  "Frames made at once; 0 is one for each core")
      .range(0, 64);
  add_drawing_options(command, simulator.drawing, simulator.gl);
  add_remote_rendering_options(command, session.rendering);
}

}  // namespace seam::app
