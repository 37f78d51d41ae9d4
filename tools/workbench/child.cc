#include "tools/workbench/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "sim_core/base/error.h"
#include "sim_core/system/own_files.h"
#include "tools/work_lines.h"

namespace seam::tools {
namespace {

constexpr size_t kMostErrorBytes = 16384;

const std::string kWithWorkLines = std::string(kWorkLines) + "=1";

// Both ends of a pipe, closed when they go.
struct Pipe {
  Pipe() {
    if (::pipe2(ends, O_CLOEXEC) != 0) throw InputError("the system grants no pipe for a command");
  }
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_end(int end) {
    if (ends[end] >= 0) ::close(ends[end]);
    ends[end] = -1;
  }
  int ends[2] = {-1, -1};
};

// Reads what is there; false at the end.
bool take(int from, std::string& text) {
  char bytes[65536];
  const ssize_t size = ::read(from, bytes, sizeof bytes);
  if (size < 0) return errno == EINTR || errno == EAGAIN;
  text.append(bytes, static_cast<size_t>(size));
  return size > 0;
}

void give_lines(std::string& text, const Child::Line& line) {
  size_t at = 0;
  for (size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', at)) {
    if (line) line(std::string_view(text).substr(at, end - at));
    at = end + 1;
  }
  text.erase(0, at);
}

}  // namespace

std::string Child::Ended::trouble() const {
  std::string text = errors;
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const size_t line = text.rfind("\nseam: ");
  if (line != std::string::npos) text.erase(0, line + 1);
  if (text.starts_with("seam: ")) text.erase(0, 6);
  if (text.empty() && code == 137)
    return "the system ended the command, perhaps because memory ran out";
  return text.empty() ? fmt::format("the command ended with code {}", code) : text;
}

void Child::start(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                  int output, int errors) {
  const std::string program = program_file();
  std::vector<char*> argv = {const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  std::vector<char*> environment = {const_cast<char*>(kWithWorkLines.c_str())};
  for (char** variable = environ; *variable != nullptr; ++variable)
    environment.push_back(*variable);
  environment.push_back(nullptr);
  const pid_t parent = ::getpid();
  const std::lock_guard lock(mutex_);
  if (stopped_) return;
  process_ = ::fork();
  if (process_ < 0) {
    process_ = 0;
    throw InputError("the system starts no process for a command");
  }
  if (process_ > 0) return;
  // Between fork and exec: async-signal-safe calls only.
  ::setpgid(0, 0);  // Ctrl-C of the terminal reaches the server alone.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int input = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (::dup2(input, STDIN_FILENO) < 0 || ::dup2(output, STDOUT_FILENO) < 0 ||
      ::dup2(errors, STDERR_FILENO) < 0 || ::chdir(folder.c_str()) != 0)
    ::_exit(127);
  ::close_range(STDERR_FILENO + 1, ~0U, 0);  // Connections of the page.
  ::execve(argv[0], argv.data(), environment.data());
  ::_exit(127);
}

Child::Ended Child::run(const std::vector<std::string>& arguments,
                        const std::filesystem::path& folder, const Line& line) {
  // Code of others runs by consent at the terminal alone.
  for (const std::string& argument : arguments) {
    if (argument.starts_with("--plugin") || argument.starts_with("--run-programs"))
      throw InputError("the workbench runs no programs and plugins of others");
  }
  Pipe output, errors;
  start(arguments, folder, output.ends[1], errors.ends[1]);
  output.close_end(1);
  errors.close_end(1);
  if (process_ == 0) return {.code = 137, .errors = {}, .stopped = true};
  std::string text, said;
  bool open[2] = {true, true};
  try {
    while (open[0] || open[1]) {
      pollfd ready[2] = {{open[0] ? output.ends[0] : -1, POLLIN, 0},
                         {open[1] ? errors.ends[0] : -1, POLLIN, 0}};
      if (::poll(ready, 2, -1) < 0 && errno != EINTR) break;
      if (ready[0].revents != 0) open[0] = take(output.ends[0], text);
      if (ready[1].revents != 0) open[1] = take(errors.ends[0], said);
      if (said.size() > 2 * kMostErrorBytes) said.erase(0, said.size() - kMostErrorBytes);
      give_lines(text, line);
    }
  } catch (...) {
    ::kill(-process_, SIGKILL);
    reap({});
    throw;
  }
  return reap(std::move(said));
}

Child::Ended Child::reap(std::string errors) {
  siginfo_t gone{};
  while (::waitid(P_PID, static_cast<id_t>(process_), &gone, WEXITED | WNOWAIT) < 0 &&
         errno == EINTR) {
  }
  // Its number may be another's once it is reaped.
  const std::lock_guard lock(mutex_);
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = 0;
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          .errors = std::move(errors),
          .stopped = stopped_};
}

void Child::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  if (process_ > 0) ::kill(-process_, SIGKILL);
}

void Child::allow() {
  const std::lock_guard lock(mutex_);
  stopped_ = false;
}

}  // namespace seam::tools
