#include "app/import/pictures/finder.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <sstream>
#include <thread>

#include "sim_core/base/error.h"
#include "sim_core/system/own_files.h"
#include "sim_core/system/work_tally.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr int kMostWait_ms = 180'000;
constexpr size_t kMostAnswerBytes = 16 << 20;
constexpr const char* kBrokeDown = "the reader of pictures broke down on it";

// One process: gets the name of a picture, gives its answer.
class Reader {
 public:
  explicit Reader(const std::vector<std::string>& command) : command_(command) { start(); }
  ~Reader() { end(); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  int socket() const { return socket_; }

  void ask(size_t picture, const std::string& name) {
    picture_ = picture, busy_ = true;
    text_.clear();
    const std::string line = name + "\n";
    for (size_t at = 0; at < line.size();) {
      const ssize_t sent = send(socket_, line.data() + at, line.size() - at, MSG_NOSIGNAL);
      if (sent <= 0) return;  // It is gone, which reading will show.
      at += static_cast<size_t>(sent);
    }
  }

  bool busy() const { return busy_; }
  size_t picture() const { return picture_; }

  // Reads what has come; true once the answer is whole, or will never be.
  bool take(std::string& answer) {
    char bytes[65536];
    const ssize_t count = recv(socket_, bytes, sizeof bytes, 0);
    if (count < 0 && errno == EINTR) return false;
    if (count > 0) text_.append(bytes, static_cast<size_t>(count));
    if (count <= 0 || text_.size() > kMostAnswerBytes) return give_up(answer);
    if (text_ != "end\n" && !text_.ends_with("\nend\n")) return false;
    answer = text_;
    busy_ = false;
    return true;
  }

  // Ends the process, which does not answer, and starts another.
  bool give_up(std::string& answer) {
    answer = fmt::format("without {}\nend\n", kBrokeDown);
    busy_ = false;
    end();
    start();
    return true;
  }

 private:
  void start() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw InputError("no process can be started to read pictures");
    std::vector<char*> argv;
    for (std::string& word : command_) argv.push_back(word.data());
    argv.push_back(nullptr);
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ == 0) {
      // Between fork and exec: async-signal-safe calls only.
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(127);
      dup2(ends[1], STDIN_FILENO);
      dup2(ends[1], STDOUT_FILENO);
      execv(argv[0], argv.data());
      _exit(127);
    }
    close(ends[1]);
    socket_ = ends[0];
    if (process_ < 0) throw InputError("no process can be started to read pictures");
  }

  void end() {
    if (socket_ >= 0) close(socket_);
    if (process_ > 0) {
      kill(process_, SIGKILL);
      while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    socket_ = -1, process_ = -1;
  }

  std::vector<std::string> command_;
  pid_t process_ = -1;
  int socket_ = -1;
  bool busy_ = false;
  size_t picture_ = 0;
  std::string text_;
};

std::vector<std::string> command_for(const TargetSpec& target) {
  const fs::path program = program_file().parent_path() / "seam-pictures";
  if (!fs::exists(program))
    throw InputError(fmt::format(
        "{}: no such program, which looks for targets in pictures; SEAM builds it where "
        "libopencv-contrib-dev, libapriltag-dev and libexif-dev are (package "
        "seam-images)",
        program.string()));
  return {program.string(),
          target.pattern,
          fmt::format("{}", target.columns),
          fmt::format("{}", target.rows),
          fmt::format("{}", target.marker_ratio),
          fmt::format("{}", target.dictionary)};
}

}  // namespace

PictureAnswer answer_of(const std::string& text, size_t target_points) {
  PictureAnswer answer;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && line != "end";) {
    std::istringstream words(line);
    std::string what;
    words >> what;
    if (what == "size") {
      words >> answer.width_px >> answer.height_px;
    } else if (what == "time") {
      int64_t ns = 0;
      if (words >> ns) answer.time_ns = ns;
    } else if (what == "edge") {
      words >> answer.edge_px;
    } else if (what == "corner") {
      FoundPoint found;
      const bool holds = words >> found.point >> found.u_px >> found.v_px &&
                         found.point < target_points && std::isfinite(found.u_px) &&
                         std::isfinite(found.v_px);
      if (!holds) return {.without = kBrokeDown};
      answer.points.push_back(found);
    } else if (what == "without") {
      answer.without = line.size() > 8 ? line.substr(8) : kBrokeDown;
    } else {
      return {.without = kBrokeDown};
    }
  }
  if (answer.points.empty() && answer.without.empty()) answer.without = kBrokeDown;
  return answer;
}

std::vector<PictureAnswer> find_targets(const std::vector<fs::path>& pictures,
                                        const TargetSpec& target,
                                        const std::function<void(size_t)>& on_answer) {
  const std::vector<std::string> command = command_for(target);
  const size_t cores = std::clamp<size_t>(std::thread::hardware_concurrency(), 1, 32);
  std::vector<std::unique_ptr<Reader>> readers;
  for (size_t i = 0; i < std::min(cores, pictures.size()); ++i)
    readers.push_back(std::make_unique<Reader>(command));
  std::vector<PictureAnswer> answers(pictures.size());
  size_t next = 0, done = 0;
  const Work work("pictures", pictures.size());
  const auto give_work = [&](Reader& reader) {
    if (next < pictures.size()) reader.ask(next, pictures[next].string()), ++next;
  };
  for (const auto& reader : readers) give_work(*reader);
  while (done < pictures.size()) {
    std::vector<pollfd> waiting;
    for (const auto& reader : readers)
      waiting.push_back({reader->busy() ? reader->socket() : -1, POLLIN, 0});
    const int ready = poll(waiting.data(), waiting.size(), kMostWait_ms);
    if (ready < 0 && errno == EINTR) continue;
    for (size_t i = 0; i < readers.size(); ++i) {
      Reader& reader = *readers[i];
      std::string text;
      if (!reader.busy() || (ready > 0 && waiting[i].revents == 0)) continue;
      if (!(ready > 0 ? reader.take(text) : reader.give_up(text))) continue;
      answers[reader.picture()] = answer_of(text, target.points.size());
      on_answer(++done);
      work.done();
      give_work(reader);
    }
  }
  return answers;
}

}  // namespace seam::app
