#include "app/session/behaviours.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

extern char** environ;  // NOLINT: POSIX's name.

namespace seam::app {

namespace {

bool is_program(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) && access(path.c_str(), X_OK) == 0;
}

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return fmt::format("was ended by signal {}", WTERMSIG(status));
  return fmt::format("ended with exit code {}", WEXITSTATUS(status));
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
    if (is_program(name)) return std::filesystem::absolute(name).string();
    throw InputError(fmt::format("robot '{}': behaviour '{}' is no program", robot, name));
  }
  const auto here = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::filesystem::path ours = here / "behaviours" / name;
  if (is_program(ours)) return ours.string();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && is_program(std::filesystem::path(folder) / name))
      return (std::filesystem::path(folder) / name).string();
  throw InputError(fmt::format("robot '{}': no behaviour '{}' in {} or PATH", robot, name,
                               (here / "behaviours").string()));
}

BlockedSignals::BlockedSignals() {
  const sigset_t set = our_signals();
  pthread_sigmask(SIG_BLOCK, &set, &before_);
  ::signal(SIGPIPE, SIG_IGN);
}

BlockedSignals::~BlockedSignals() {
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void Behaviours::start(const BehaviourProcess& process) {
  std::vector<std::string> command = process.command;
  std::vector<std::string> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) environment.emplace_back(*entry);
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
    execve(argv[0], argv.data(), envp.data());
    _exit(127);
  }
  running_[pid] = process.robot;
}

void Behaviours::reap(const std::function<void(const std::string&, const std::string&)>& ended) {
  for (auto it = running_.begin(); it != running_.end();) {
    int status = 0;
    if (waitpid(it->first, &status, WNOHANG) == it->first) {
      ended(it->second, how_it_ended(status));
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
  // To the whole group: a behaviour may have started processes of its own.
  for (const auto& [pid, robot] : running_) kill(-pid, SIGTERM);
  wait_for_end(0.5);
  for (const auto& [pid, robot] : running_) kill(-pid, SIGKILL);
  for (const auto& [pid, robot] : running_) waitpid(pid, nullptr, 0);
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
