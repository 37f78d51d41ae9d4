#include "app/session/runs_made_here.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/sha.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "app/session/behaviours.h"
#include "sim_core/base/error.h"

namespace seam::app {
namespace {

namespace fs = std::filesystem;

constexpr size_t kLineBytes = 2 * SHA256_DIGEST_LENGTH + 1;
// The older half is forgotten beyond it.
constexpr size_t kMostRuns = 4096;

fs::path usual_file() {
  const auto folder_of = [](const char* variable) {
    const char* value = std::getenv(variable);
    const fs::path path = value == nullptr ? "" : value;
    return path.is_absolute() ? path : fs::path();
  };
  if (const fs::path state = folder_of("XDG_STATE_HOME"); !state.empty())
    return state / "seam" / "runs";
  const fs::path home = folder_of("HOME");
  return home.empty() ? home : home / ".local" / "state" / "seam" / "runs";
}

// What a run is known by; empty for one without programs, or one whose programs are not there.
std::vector<std::string> texts_of(const Simulator& simulator) {
  std::vector<std::string> texts;
  for (const RobotSpec& robot : simulator.scenario.robots) {
    const std::vector<std::string>& command = robot.behaviour.command;
    if (command.empty()) continue;
    try {
      texts.push_back(find_behaviour(command[0], robot.id));
    } catch (const InputError&) {
      return {};
    }
  }
  if (!texts.empty()) texts.insert(texts.begin(), simulator.header.scenario_text);
  return texts;
}

// Empty for no texts.
std::string line_of(std::vector<std::string> texts) {
  if (texts.empty()) return "";
  std::error_code error;
  texts.insert(texts.begin(), fs::current_path(error).string());
  if (error) return "";
  std::string whole;
  for (const std::string& text : texts)
    whole += fmt::format("{}:{}\n", text.size(), text);  // No two lists of texts look the same.
  unsigned char digest[SHA256_DIGEST_LENGTH];
  SHA256(reinterpret_cast<const unsigned char*>(whole.data()), whole.size(), digest);
  std::string line;
  for (const unsigned char byte : digest) line += fmt::format("{:02x}", byte);
  return line + "\n";
}

// The file, locked until it is closed.
class StateFile {
 public:
  StateFile(const fs::path& path, int flags, int lock) {
    descriptor_ = open(path.c_str(), flags | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (descriptor_ >= 0 && (!is_private() || flock(descriptor_, lock) != 0)) {
      close(descriptor_);
      descriptor_ = -1;
    }
  }
  ~StateFile() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  bool is_open() const { return descriptor_ >= 0; }
  std::string text() const {
    std::string all(kMostRuns * kLineBytes, '\0');
    const ssize_t got = pread(descriptor_, all.data(), all.size(), 0);
    all.resize(got < 0 ? 0 : static_cast<size_t>(got) / kLineBytes * kLineBytes);
    return all;
  }
  void replace(const std::string& text) const {
    if (ftruncate(descriptor_, 0) != 0) return;
    append(text, 0);
  }
  void append(const std::string& text, size_t at) const {
    [[maybe_unused]] const ssize_t written =
        pwrite(descriptor_, text.data(), text.size(), static_cast<off_t>(at));
  }

 private:
  // What others could have written says nothing.
  bool is_private() const {
    struct stat status {};
    return fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode) &&
           status.st_uid == geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
  }
  int descriptor_ = -1;
};

bool holds_line(const std::string& text, const std::string& line) {
  for (size_t at = 0; at + kLineBytes <= text.size(); at += kLineBytes)
    if (text.compare(at, kLineBytes, line) == 0) return true;
  return false;
}

}  // namespace

RunsMadeHere::RunsMadeHere() : file_(usual_file()) {}

bool RunsMadeHere::holds(const Simulator& simulator) const {
  return holds(texts_of(simulator));
}

void RunsMadeHere::note(const Simulator& simulator) const {
  note(texts_of(simulator));
}

bool RunsMadeHere::holds(const std::vector<std::string>& texts) const {
  if (file_.empty()) return false;
  const std::string line = line_of(texts);
  if (line.empty()) return false;
  const StateFile file(file_, O_RDONLY, LOCK_SH);
  return file.is_open() && holds_line(file.text(), line);
}

void RunsMadeHere::note(const std::vector<std::string>& texts) const {
  if (file_.empty()) return;
  const std::string line = line_of(texts);
  if (line.empty()) return;
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  const StateFile file(file_, O_RDWR | O_CREAT, LOCK_EX);
  if (!file.is_open()) return;
  const std::string text = file.text();
  if (holds_line(text, line)) return;
  if (text.size() >= kMostRuns * kLineBytes)
    file.replace(text.substr(text.size() / kLineBytes / 2 * kLineBytes) + line);
  else
    file.append(line, text.size());
}

}  // namespace seam::app
