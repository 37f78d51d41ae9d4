// A run from its parts: server, behaviours, log, frames, summary. `seam run` and `seam serve` are
// the two ways into it; replays with live clients use it too.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/command_line.h"
#include "app/session/logged_values.h"
#include "app/session/memory_watch.h"
#include "app/session/remote_rendering.h"
#include "app/simulator.h"
#include "scheduler/clients/client_hub.h"
#include "scheduler/log/recorder.h"
#include "scheduler/loop/command_notes.h"
#include "scheduler/loop/simulation.h"
#include "scheduler/server/server.h"

namespace seam::app {

class Standbys;

// A robot whose program the user starts, such as in a debugger; `file` gets the environment that it
// needs. No name: none.
struct ByHand {
  std::string robot;
  std::string file;
};

struct SessionOptions {
  std::string log;       // Empty: none.
  std::string sign_key;  // Private, for a signature beside the log; empty: none.
  scheduler::RecorderOptions recording;
  std::string frames;                         // Folder; empty: none.
  std::string json;                           // Summary; empty: none.
  bool durable = false;                       // The log survives a power cut up to its last chunk.
  bool force = false;                         // A log and frames of an earlier run are replaced.
  std::vector<std::filesystem::path> inputs;  // What is read: no output may be one of these.
  bool start_behaviours = true;
  bool state_hashes = true;            // Without: no fingerprint, and no steps in a log.
  std::vector<std::string> addresses;  // Beside the private socket of the behaviours.
  std::string certificates;            // Folder with ca.pem, server.pem, server.key.
  std::string token_file;              // Tokens are written here for clients elsewhere.
  RemoteRenderingOptions rendering;
  std::map<std::string, std::vector<std::string>> commands;  // Replace the scenario's, by robot.
  // Robots whose clients a script drives, and where their direct lines are.
  std::vector<std::string> driven;
  std::string lines;
  bool until_eof = false;    // The run stops when standard input ends.
  ByHand by_hand;            // Its command is an empty one.
  bool progress = true;      // On a terminal.
  bool show_printed = true;  // What behaviours print goes to stderr, each line with its robot.
  std::optional<double> wall_limit_s;            // A run that takes longer is aborted.
  scheduler::FrameRenderer* renderer = nullptr;  // In place of the simulator's.
  Standbys* standbys = nullptr;                  // Of a process that makes many runs; null: none.
  // May put another renderer in front of the run's own.
  std::function<std::unique_ptr<scheduler::FrameRenderer>(scheduler::FrameRenderer& own)>
      wrap_renderer;
};

// What a run was made from.
struct SessionIdentity {
  std::string scenario;     // Its name.
  std::string fingerprint;  // Of the whole scenario with all changes and models, tokens apart.
  std::vector<ScenarioChange> changes;
  int64_t seed = 0;
  std::vector<std::pair<std::string, std::string>> versions;
  struct RobotModel {
    std::string robot;
    std::string model;        // The model's own name.
    std::string fingerprint;  // Of the values that this robot has.
  };
  std::vector<RobotModel> models;
};
SessionIdentity identity_of(const Simulator& simulator);

struct SessionSummary {
  SessionIdentity identity;
  LoggedSummaries logged;  // What behaviours logged as values.
  double sim_s = 0;
  double wall_s = 0;
  double waiting_s = 0;  // Of wall_s: for clients.
  uint64_t frames = 0;
  uint64_t rendered_remotely = 0;  // Of them: by `seam-render` processes.
  uint64_t decisions = 0;
  uint64_t fingerprint = 0;
  bool has_fingerprint = true;  // False: some frames were not drawn.
  bool has_score = false;       // A referee kept it.
  int red_score = 0, blue_score = 0;
  std::vector<MemorySample> memory;  // Of the server, each 10 simulated seconds.
  uint64_t log_bytes = 0;            // Of the replay log; 0: none.
  scheduler::EndReason end = scheduler::EndReason::finished;
  std::string abort_reason;
  std::map<std::string, scheduler::CommandNotes::Refused> refused;  // By robot.
  std::vector<std::string> refused_lines, clamped_lines;            // For people.
  std::vector<std::string> last_lines;  // That behaviours printed, at most 50 a robot.

  double real_time_factor() const { return wall_s > 0 ? sim_s / wall_s : 0; }
};

// `wrap` may put another source of decisions in front of the live clients.
using WrapSource =
    std::function<std::unique_ptr<scheduler::DecisionSource>(scheduler::LiveSource& live)>;

struct SessionOutputs;

// Runs to the end, Ctrl-C or abort. Throws InputError and UsageError before anything was started.
SessionSummary run_session(Simulator& simulator, const SessionOptions& options,
                           SessionOutputs& outputs, const WrapSource& wrap = {},
                           std::vector<scheduler::SimulationObserver*> observers = {});

// The summary on stdout and, where asked for, as JSON; the exit code.
int report(const SessionSummary& summary, SessionOutputs& outputs);

// A server's certificates, from the folder of --certs; none where that is empty.
std::optional<scheduler::TlsTexts> read_certificates(const std::string& folder);

// `--renderer auto|analytic|opengl`, `--gl auto|osmesa|egl`; what `auto` takes for a renderer.
void add_drawing_options(Command command, std::string& drawing, std::string& gl,
                         const std::string& automatic = "opengl where the scene needs it");

// The options that run and serve share.
void add_session_options(Command command, SessionOptions& session, SimulatorOptions& simulator);

}  // namespace seam::app
