#include "tools/dm_env_rpc/run.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <chrono>
#include <filesystem>
#include <utility>

#include "app/session/behaviours.h"
#include "sim_core/base/error.h"
#include "sim_core/base/files.h"
#include "sim_core/input/shown_text.h"
#include "sim_core/system/thread.h"
#include "tools/dm_env_rpc/request_error.h"

namespace seam::tools::dm {

namespace {

constexpr size_t kKeptBytes = 4096;  // Of what a process prints.
constexpr double kEnd_s = 10;        // For a process to end by itself.

}  // namespace

RobotLine::RobotLine(const std::string& path, const std::string& robot, const std::string& token)
    : stream_(path) {
  v1::ClientMessage hello;
  hello.mutable_hello()->set_robot(robot);
  hello.mutable_hello()->set_token(token);
  hello.mutable_hello()->set_client("seam dm_env_rpc 1");
  stream_.Write(hello);
}

void RobotLine::answer(v1::Decision decision) {
  v1::ClientMessage message;
  *message.mutable_decision() = std::move(decision);
  message.mutable_decision()->set_sequence(sequence_);
  refused_.clear();
  stream_.Write(message);
}

std::optional<v1::Observation> RobotLine::next() {
  v1::ServerMessage message;
  while (stream_.Read(&message)) {
    if (message.has_goodbye()) return std::nullopt;
    if (message.has_refusal())
      refused_ = fmt::format("{}: {}", message.refusal().field(), message.refusal().message());
    if (!message.has_observation()) continue;
    sequence_ = message.observation().sequence();
    return std::move(*message.mutable_observation());
  }
  throw RequestError(grpc::StatusCode::UNAVAILABLE,
                     "the run ended: " + stream_.Finish().error_message());
}

Run::Run(const RunCommand& command, int64_t seed, const std::string& log) {
  const std::filesystem::path& here = folder_.path();
  std::vector<std::string> words = command.words;
  for (const std::string& word :
       {std::string("--listen"), "unix:" + (here / "socket").string(), std::string("--lines"),
        (here / "lines").string(), std::string("--tokens"), (here / "tokens").string(),
        std::string("--seed"), std::to_string(seed)})
    words.push_back(word);
  if (!command.logs.empty()) {
    words.emplace_back("--log");
    words.push_back((std::filesystem::path(command.logs) / log).string());
  }
  thread_ = start_thread([this, words] { watch(words); });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return listening_ || ended_; });
  if (listening_) return;
  lock.unlock();
  throw RequestError(grpc::StatusCode::FAILED_PRECONDITION,
                     "the run cannot begin: " + last_words());
}

Run::~Run() {
  send(SIGTERM);
  if (!wait_ended(kEnd_s)) send(SIGKILL);
}

void Run::watch(std::vector<std::string> words) {
  int ends[2] = {-1, -1};
  pid_t pid = -1;
  try {
    if (::pipe2(ends, O_CLOEXEC) != 0) throw InputError("no pipe for a process");
    pid = app::start_program({"", std::move(words), {}, ends[1]});
  } catch (const std::exception& error) {
    const std::lock_guard lock(mutex_);
    printed_ = error.what();
  }
  if (ends[1] >= 0) ::close(ends[1]);
  {
    const std::lock_guard lock(mutex_);
    pid_ = pid;
  }
  if (pid >= 0) wait_for_end(pid, ends[0]);
  if (ends[0] >= 0) ::close(ends[0]);
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

// Reads what it prints, until it is gone.
void Run::wait_for_end(pid_t pid, int output) {
  bool open = true;
  siginfo_t gone{};
  while (gone.si_pid == 0) {
    if (open) {
      char bytes[4096];
      pollfd readable{output, POLLIN, 0};
      const bool ready = ::poll(&readable, 1, 50) > 0;
      const ssize_t count = ready ? ::read(output, bytes, sizeof bytes) : 0;
      open = !ready || count > 0;
      const std::lock_guard lock(mutex_);
      if (count > 0) printed_.append(bytes, static_cast<size_t>(count));
      if (!listening_ && printed_.find("listening on ") != std::string::npos) {
        listening_ = true;
        printed_.clear();
        changed_.notify_all();
      }
      if (printed_.size() > 2 * kKeptBytes) printed_.erase(0, printed_.size() - kKeptBytes);
    }
    ::waitid(P_PID, static_cast<id_t>(pid), &gone, WEXITED | WNOWAIT | (open ? WNOHANG : 0));
  }
  int status = 0;
  // Nobody sends a signal to this number any more once it may belong to another process.
  const std::lock_guard lock(mutex_);
  ::waitpid(pid, &status, 0);
  pid_ = -1;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

bool Run::wait_ended(double limit_s) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, std::chrono::duration<double>(limit_s), [&] { return ended_; });
}

void Run::send(int signal) {
  const std::lock_guard lock(mutex_);
  if (pid_ > 0) ::kill(pid_, signal);
}

int Run::finish() {
  if (!wait_ended(kEnd_s)) send(SIGTERM);
  wait_ended(kEnd_s);
  const std::lock_guard lock(mutex_);
  return exit_code_;
}

std::string Run::last_words() const {
  const std::lock_guard lock(mutex_);
  std::string text =
      printed_.size() > kKeptBytes ? printed_.substr(printed_.size() - kKeptBytes) : printed_;
  while (text.ends_with('\n')) text.pop_back();
  return text.empty() ? "its process ended without a word" : shown_lines(text);
}

std::unique_ptr<RobotLine> Run::line_of(const std::string& robot) const {
  const YAML::Node tokens = YAML::Load(read_file(folder_.path() / "tokens"));
  return std::make_unique<RobotLine>((folder_.path() / "lines").string(), robot,
                                     tokens["robots"][robot].as<std::string>());
}

}  // namespace seam::tools::dm
