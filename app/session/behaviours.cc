#include "app/session/behaviours.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/session/standbys.h"
#include "sim_core/base/error.h"
#include "sim_core/input/shell_word.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/signals/half_made.h"
#include "sim_core/system/own_files.h"
#include "sim_core/system/thread.h"

extern char** environ;  // NOLINT: POSIX's name.

namespace seam::app {

namespace {

constexpr const char* kAllRobots = "*";

bool is_program(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

std::vector<std::filesystem::path> search_path() {
  std::vector<std::filesystem::path> places;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty()) places.emplace_back(folder);
  return places;
}

bool found_in(const std::vector<std::filesystem::path>& places, const std::string& name) {
  return std::any_of(places.begin(), places.end(),
                     [&](const auto& place) { return is_program(place / name); });
}

// What keeps a file from being started as a program; empty where nothing does.
std::string why_no_program(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    return "is not there: neither beside the scenario nor in the working folder";
  if (!std::filesystem::is_regular_file(path, error)) return "is no file, expected a program";
  if (access(path.c_str(), X_OK) != 0) return "is not executable: chmod +x makes it so";
  std::ifstream file(path, std::ios::binary);
  if (!file) return "";         // One that may be started and not read: the system knows.
  std::string line(256, '\0');  // As much as the system looks at.
  file.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(static_cast<size_t>(file.gcount()));
  if (line.starts_with("\x7f"
                       "ELF"))
    return "";
  line = line.substr(0, line.find('\n'));
  if (!line.starts_with("#!"))
    return "has no #! in its first line, expected #!/usr/bin/python3 or whatever is to run it";
  // Which the system takes for a part of the interpreter's name.
  if (line.ends_with('\r'))
    return "ends its #! line as Windows does, with a carriage return: sed -i 's/\\r$//' removes "
           "them";
  std::istringstream words(line.substr(2));
  std::string interpreter;
  words >> interpreter;
  if (is_program(interpreter)) {
    if (std::filesystem::path(interpreter).filename() != "env") return "";
    // What `env` is to find: the first word that is neither an option nor a variable.
    while (words >> interpreter)
      if (!interpreter.starts_with('-') && interpreter.find('=') == std::string::npos) break;
    if (!words || found_in(search_path(), interpreter)) return "";
    return fmt::format("names in its #! line '{}', which env finds nowhere in PATH",
                       shown(interpreter));
  }
  return fmt::format("names in its #! line '{}', which is no program", shown(interpreter));
}

std::string how_it_ended(const siginfo_t& state) {
  return fmt::format("{} {}",
                     state.si_code == CLD_EXITED ? "ended with exit code" : "was ended by signal",
                     state.si_status);
}

sigset_t our_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (int signal : {SIGINT, SIGTERM, SIGCHLD}) sigaddset(&set, signal);
  // `nohup` asks that the end of a terminal does not end the run.
  struct sigaction action {};
  sigaction(SIGHUP, nullptr, &action);
  if (action.sa_handler != SIG_IGN) sigaddset(&set, SIGHUP);
  return set;
}

// Pointers to texts, ended by a null pointer, as exec takes them.
std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

}  // namespace

std::string find_behaviour(const std::string& name, const std::string& robot) {
  if (name.find('/') != std::string::npos) {
    if (const std::string fault = why_no_program(name); !fault.empty())
      throw InputError(fmt::format("robot '{}': behaviour '{}' {}", robot, name, fault));
    return std::filesystem::absolute(name).string();
  }
  const std::filesystem::path folder_of_ours = behaviours_folder();
  std::vector<std::filesystem::path> places = search_path();
  places.insert(places.begin(), folder_of_ours);
  for (const std::filesystem::path& place : places) {
    if (!is_program(place / name)) continue;
    if (const std::string fault = why_no_program(place / name); !fault.empty())
      throw InputError(
          fmt::format("robot '{}': behaviour '{}' {}", robot, (place / name).string(), fault));
    return (place / name).string();
  }
  std::error_code unknown;
  throw InputError(fmt::format(
      "robot '{}': no behaviour '{}' in {} or PATH{}", robot, name, folder_of_ours.string(),
      std::filesystem::exists(name, unknown)
          ? fmt::format("; for the file of this name here write ./{}", name)
          : ""));
}

std::map<std::string, std::string> behaviour_environment() {
  const std::filesystem::path package = python_folder();
  if (package.empty()) return {};
  // What the user names goes before ours.
  const char* theirs = std::getenv("PYTHONPATH");
  const std::string before = theirs == nullptr || *theirs == '\0' ? "" : std::string(theirs) + ":";
  return {{"PYTHONPATH", before + package.string()}};
}

std::string environment_lines(const std::map<std::string, std::string>& environment) {
  std::string lines;
  // Quotes are for a shell; not all editors take them off.
  for (const auto& [name, value] : environment)
    lines += name + "=" + (value.empty() ? "" : shell_word(value)) + "\n";
  return lines;
}

bool is_driven(const std::vector<std::string>& driven, const std::string& robot) {
  return std::any_of(driven.begin(), driven.end(),
                     [&](const std::string& name) { return name == robot || name == kAllRobots; });
}

void require_driven_robots(const std::vector<std::string>& driven, const Scenario& scenario) {
  std::vector<std::string> known;
  for (const RobotSpec& robot : scenario.robots) known.push_back(robot.id);
  for (const std::string& name : driven)
    if (name != kAllRobots && std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError(fmt::format("--drive {}: no robot of the scenario{}", shown(name),
                                   suggestion_for(name, known)));
}

bool input_has_ended() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  if (::poll(&input, 1, 0) <= 0) return false;
  char ignored[256];
  return (input.revents & POLLIN) == 0 || ::read(STDIN_FILENO, ignored, sizeof ignored) <= 0;
}

BlockedSignals::BlockedSignals() {
  const sigset_t set = our_signals();
  pthread_sigmask(SIG_BLOCK, &set, &before_);
  ::signal(SIGPIPE, SIG_IGN);
}

BlockedSignals::~BlockedSignals() {
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

pid_t start_program(const BehaviourProcess& process, int inherited) {
  std::vector<std::string> command = process.command;
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    if (!process.environment.contains(std::string(text.substr(0, text.find('=')))))
      environment.emplace_back(text);
  }
  for (const auto& [name, value] : process.environment) environment.push_back(name + "=" + value);
  std::vector<char*> argv = pointers(command);
  std::vector<char*> envp = pointers(environment);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw InputError(fmt::format("robot '{}': cannot start a process", process.robot));
  if (pid == 0) {
    // Between fork and exec: async-signal-safe calls only.
    setpgid(0, 0);  // Ctrl-C of the terminal reaches the server alone, which ends the behaviours.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(127);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    ::signal(SIGPIPE, SIG_DFL);
    // Who reads the terminal outside its foreground group is stopped, and nobody would say so.
    if (isatty(STDIN_FILENO) != 0) dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    if (inherited >= 0) fcntl(inherited, F_SETFD, 0);
    if (process.output >= 0)
      for (const int own : {STDOUT_FILENO, STDERR_FILENO}) dup2(process.output, own);
    execve(argv[0], argv.data(), envp.data());
    _exit(127);
  }
  return pid;
}

void Behaviours::start(const BehaviourProcess& process) {
  running_[standbys_ != nullptr ? standbys_->start(process) : start_program(process)] =
      process.robot;
}

void Behaviours::reap(const std::function<void(const std::string&, const std::string&)>& ended) {
  if (standbys_ != nullptr) {
    for (const auto& [standby, client] : standbys_->take_first_clients()) {
      auto entry = running_.extract(standby);
      entry.key() = client;
      running_.insert(std::move(entry));
    }
  }
  for (auto it = running_.begin(); it != running_.end();) {
    siginfo_t state{};
    const auto process = static_cast<id_t>(it->first);
    if (waitid(P_PID, process, &state, WEXITED | WNOHANG | WNOWAIT) == 0 &&
        state.si_pid == it->first) {
      ended(it->second, how_it_ended(state));
      ended_.push_back(it->first);
      it = running_.erase(it);
    } else {
      ++it;
    }
  }
}

void Behaviours::wait_for_end(double limit_s) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
  while (any_running() && std::chrono::steady_clock::now() < deadline) {
    reap([](const std::string&, const std::string&) {});
    if (any_running()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

Behaviours::~Behaviours() {
  // To the whole group: a behaviour may have started processes of its own, and have ended.
  for (const auto& [pid, robot] : running_) kill(-pid, SIGTERM);
  for (const pid_t pid : ended_) kill(-pid, SIGTERM);
  wait_for_end(0.5);
  for (const auto& [pid, robot] : running_) ended_.push_back(pid);
  for (const pid_t pid : ended_) {
    kill(-pid, SIGKILL);
    kill(pid, SIGKILL);  // Where it has left its group, or not come to it yet.
    waitpid(pid, nullptr, 0);
    while (waitpid(-pid, nullptr, 0) > 0) {
    }  // Whoever of the group fell to us.
  }
}

SignalWatch::SignalWatch(std::function<void()> stop, std::function<void()> child)
    : thread_(start_thread([this, stop, child] {
        const sigset_t set = our_signals();
        const timespec tick{0, 100'000'000};
        // `timeout` and terminals may send a signal twice at once; that is one wish to stop.
        constexpr std::chrono::seconds kImpatient{1};
        std::chrono::steady_clock::time_point first;
        while (!ending_) {
          const int signal = sigtimedwait(&set, nullptr, &tick);
          if (signal == SIGINT || signal == SIGTERM || signal == SIGHUP) {
            const auto now = std::chrono::steady_clock::now();
            if (!interrupted_.exchange(true)) {
              first = now;
              stop();
            } else if (now - first > kImpatient) {
              remove_half_made();
              _exit(130);  // PDEATHSIG ends the behaviours.
            }
          }
          child();
        }
      })) {}

SignalWatch::~SignalWatch() {
  ending_ = true;
  // Wakes it: a short run need not wait for its next look around.
  pthread_kill(thread_.native_handle(), SIGCHLD);
  thread_.join();
}

}  // namespace seam::app
