#include "app/sweep/workers.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>
#include <vector>

#include "sim_core/base/error.h"

namespace seam::app {
namespace {

constexpr int kTick_ms = 200;
constexpr int kGrace_ms = 3000;  // For workers that were asked to end.
constexpr size_t kMostResultBytes = 256 << 10;
constexpr size_t kMostMessageBytes = 2000;
// A program that cannot work at all does not go through the whole plan.
constexpr int kMostDeathsInARow = 20;

struct Worker {
  pid_t process = -1;
  int socket = -1;    // A job's number to it, the result back: a message each.
  int messages = -1;  // What it and its behaviours write.
  std::optional<uint64_t> job;
};

// A fork takes the calling thread alone with it: locks that others hold would stay locked for ever.
size_t threads_of_this_process() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<size_t>(std::distance(begin(tasks), end(tasks)));
}

// The worker's side: never returns.
[[noreturn]] void serve(int socket, int messages, const WorkerCalls& calls) {
  ::dup2(messages, STDOUT_FILENO);
  ::dup2(messages, STDERR_FILENO);
  uint64_t job = 0;
  while (::recv(socket, &job, sizeof job, 0) == sizeof job) {
    // Messages of the job before are of no interest any more.
    if (::ftruncate(messages, 0) != 0) ::_exit(1);
    const std::string result = calls.work(job);
    std::fflush(nullptr);
    if (result.empty() || ::send(socket, result.data(), result.size(), MSG_NOSIGNAL) < 0) break;
  }
  ::_exit(0);
}

class Pool {
 public:
  explicit Pool(const WorkerCalls& calls) : calls_(calls) {
    sigset_t wanted;
    sigemptyset(&wanted);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&wanted, signal);
    pthread_sigmask(SIG_BLOCK, &wanted, &before_);
    signals_ = ::signalfd(-1, &wanted, SFD_CLOEXEC | SFD_NONBLOCK);
  }
  ~Pool() {
    for (const Worker& worker : workers_) ::kill(worker.process, SIGTERM);
    for (const Worker& worker : workers_) end(worker);
    ::close(signals_);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;

  bool run(int workers);

 private:
  void start();
  void give(Worker& worker);
  void take(Worker& worker);
  void bury(Worker& worker);
  static void end(const Worker& worker);

  const WorkerCalls& calls_;
  sigset_t before_;
  int signals_ = -1;
  std::vector<Worker> workers_;
  bool all_given_ = false;
  int deaths_ = 0;
};

void Pool::start() {
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    throw InputError("no sockets for worker processes");
  const int messages = ::memfd_create("messages", MFD_CLOEXEC);
  if (messages >= 0) ::fcntl(messages, F_SETFL, O_APPEND);
  const size_t threads = threads_of_this_process();
  SEAM_CHECK(threads == 1, "{} threads", threads);
  std::fflush(nullptr);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process < 0 || messages < 0) throw InputError("cannot start a worker process");
  if (process == 0) {
    ::setpgid(0, 0);  // Ctrl-C of the terminal reaches the parent alone, which ends its workers.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    ::close(ends[0]);
    for (const Worker& other : workers_) {
      ::close(other.socket);
      ::close(other.messages);
    }
    ::close(signals_);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    serve(ends[1], messages, calls_);
  }
  ::close(ends[1]);
  workers_.push_back({process, ends[0], messages, std::nullopt});
}

void Pool::give(Worker& worker) {
  worker.job = all_given_ ? std::nullopt : calls_.next();
  all_given_ = all_given_ || !worker.job;
  // A worker that is gone is seen when its answer is read.
  if (worker.job) ::send(worker.socket, &*worker.job, sizeof *worker.job, MSG_NOSIGNAL);
}

void Pool::take(Worker& worker) {
  std::string result(kMostResultBytes, '\0');
  const ssize_t size = ::recv(worker.socket, result.data(), result.size(), 0);
  if (size <= 0) return bury(worker);
  result.resize(static_cast<size_t>(size));
  deaths_ = 0;
  calls_.done(*worker.job, result);
  give(worker);
}

void Pool::bury(Worker& worker) {
  int status = 0;
  ::waitpid(worker.process, &status, 0);
  std::string how = WIFSIGNALED(status) ? fmt::format("ended by signal {}", WTERMSIG(status))
                                        : fmt::format("exit code {}", WEXITSTATUS(status));
  const off_t length = ::lseek(worker.messages, 0, SEEK_END);
  const off_t from = std::max<off_t>(0, length - static_cast<off_t>(kMostMessageBytes));
  std::string last(static_cast<size_t>(std::max<off_t>(0, length - from)), '\0');
  if (::pread(worker.messages, last.data(), last.size(), from) > 0) how += ": " + last;
  const std::optional<uint64_t> job = worker.job;
  ::close(worker.socket);
  ::close(worker.messages);
  workers_.erase(workers_.begin() + (&worker - workers_.data()));
  if (job) calls_.died(*job, how);
  if (++deaths_ > kMostDeathsInARow)
    throw InputError(
        fmt::format("{} runs in a row ended their processes; the last: {}", deaths_, how));
  if (all_given_) return;
  start();
  give(workers_.back());
}

void Pool::end(const Worker& worker) {
  ::shutdown(worker.socket, SHUT_RDWR);
  for (int waited = 0; ::waitpid(worker.process, nullptr, WNOHANG) == 0; waited += 5) {
    if (waited >= kGrace_ms) ::kill(worker.process, SIGKILL);
    ::usleep(5000);
  }
  ::close(worker.socket);
  ::close(worker.messages);
}

bool Pool::run(int workers) {
  for (int i = 0; i < workers && !all_given_; ++i) {
    start();
    give(workers_.back());
  }
  while (true) {
    std::vector<pollfd> waiting = {{signals_, POLLIN, 0}};
    for (const Worker& worker : workers_)
      if (worker.job) waiting.push_back({worker.socket, POLLIN, 0});
    if (waiting.size() == 1) return true;
    ::poll(waiting.data(), waiting.size(), kTick_ms);
    calls_.tick();
    // Taken, or it would act when the signals are let through again.
    signalfd_siginfo came{};
    if (waiting[0].revents != 0 && ::read(signals_, &came, sizeof came) > 0) return false;
    for (size_t i = 1; i < waiting.size(); ++i) {
      if (waiting[i].revents == 0) continue;
      const auto found = std::find_if(workers_.begin(), workers_.end(), [&](const Worker& worker) {
        return worker.socket == waiting[i].fd;
      });
      if (found != workers_.end()) take(*found);
    }
  }
}

}  // namespace

int machine_cores() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

int cores_for_each(int workers) {
  return std::max(1, machine_cores() / std::max(1, workers));
}

bool run_in_workers(int workers, const WorkerCalls& calls) {
  return Pool(calls).run(workers);
}

}  // namespace seam::app
