// The processes of a scenario's behaviours: started, watched, and always ended and reaped.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "sim_core/scenario/scenario.h"

namespace seam::app {

struct BehaviourProcess {
  std::string robot;
  std::vector<std::string> command;                // argv[0] a program's full path.
  std::map<std::string, std::string> environment;  // Added to ours, or in place of it.
  int output = -1;  // Where it writes what it prints; -1: where we do.
};

// The program that a scenario means by `name`: with a slash the path itself, else among the
// behaviours that belong to this program, else in PATH. Throws InputError where there is none, or
// where it is one that cannot be started: not executable, without #!.
std::string find_behaviour(const std::string& name, const std::string& robot);

// What behaviours find in their environment: our package on Python's path.
std::map<std::string, std::string> behaviour_environment();

// As lines NAME=VALUE, which a shell reads with `.` and editors as an `envFile`.
std::string environment_lines(const std::map<std::string, std::string>& environment);

// Whether a robot is one of these, or these are "*": all.
bool is_driven(const std::vector<std::string>& driven, const std::string& robot);
// Throws UsageError where one of these is not in the scenario.
void require_driven_robots(const std::vector<std::string>& driven, const Scenario& scenario);

// Whether whoever started this process has closed our standard input, or is gone.
bool input_has_ended();

// While it lives, the calling thread and those that it starts leave SIGINT, SIGTERM, SIGHUP and
// SIGCHLD to `SignalWatch`; a client that closes its connection does not end the program.
class BlockedSignals {
 public:
  BlockedSignals();
  ~BlockedSignals();
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_;
};

// Starts the program in a process group of its own, which ends with this process. `inherited`: a
// descriptor that it gets. Throws InputError where there is no process.
pid_t start_program(const BehaviourProcess& process, int inherited = -1);

class Standbys;

class Behaviours {
 public:
  // `standbys`: of a process that makes many runs.
  explicit Behaviours(Standbys* standbys = nullptr) : standbys_(standbys) {}
  // Ends what still runs, with what behaviours started and left: asks (SIGTERM), waits a moment,
  // kills, reaps.
  ~Behaviours();
  Behaviours(const Behaviours&) = delete;
  Behaviours& operator=(const Behaviours&) = delete;

  void start(const BehaviourProcess& process);
  // Looks who has ended, and reports each: robot, and how it ended.
  void reap(const std::function<void(const std::string&, const std::string&)>& ended);
  // Gives all of them this long to end by themselves.
  void wait_for_end(double limit_s);
  bool any_running() const { return !running_.empty(); }

 private:
  Standbys* standbys_;
  std::map<pid_t, std::string> running_;  // Robot by process.
  std::vector<pid_t> ended_;              // Reaped at the end: a group keeps its number until then.
};

// Waits for signals on a thread of its own: `stop` on the first SIGINT, SIGTERM or SIGHUP, `child`
// on SIGCHLD and every 100 ms. Another such signal a second later ends the program at once.
class SignalWatch {
 public:
  SignalWatch(std::function<void()> stop, std::function<void()> child);
  ~SignalWatch();
  bool interrupted() const { return interrupted_; }

 private:
  std::atomic<bool> ending_ = false;
  std::atomic<bool> interrupted_ = false;
  std::jthread thread_;
};

}  // namespace seam::app
