#include "app/session/session_outputs.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "sim_core/base/error.h"

namespace seam::app {

namespace {

namespace fs = std::filesystem;

// Whether a log of this name replaces a file: what a link below /proc leads to (as /dev/stdout) is
// written where it is.
bool replaces_file(const fs::path& log) {
  std::error_code unknown;
  if (!fs::is_regular_file(log, unknown)) return false;
  for (fs::path path = log; fs::is_symlink(path, unknown);
       path = path.parent_path() / fs::read_symlink(path)) {
    if (fs::weakly_canonical(fs::absolute(path).parent_path()).string().starts_with("/proc"))
      return false;
  }
  return true;
}

}  // namespace

ReplacedLog::ReplacedLog(const fs::path& log) : log_(fs::canonical(log)), growing_(log_) {
  growing_ += ".part";
  lock_ = ::open(log_.c_str(), O_WRONLY | O_CLOEXEC);
  if (lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) == 0) return;
  const std::string why = lock_ >= 0 ? "another run is writing this file"
                                     : fmt::format("cannot be written: {}", std::strerror(errno));
  if (lock_ >= 0) ::close(lock_);
  throw InputError(fmt::format("{}: {}", log.string(), why));
}

ReplacedLog::~ReplacedLog() {
  if (!growing_.empty()) ::unlink(growing_.c_str());
  ::close(lock_);
}

void ReplacedLog::finish() {
  std::error_code error;
  fs::permissions(growing_, fs::status(log_).permissions(), error);
  fs::rename(growing_, log_, error);
  if (error)
    throw InputError(fmt::format("{}: cannot be written: {}", log_.string(), error.message()));
  growing_.clear();
}

void SessionOutputs::fill_tokens(const std::vector<scheduler::HubRobot>& robots,
                                 const std::string& supervisor, const std::string& render) {
  if (!tokens) return;
  std::string text = fmt::format("supervisor: {}\nrender: {}\nrobots:\n", supervisor, render);
  for (const scheduler::HubRobot& robot : robots)
    text += fmt::format("  {}: {}\n", robot.id, robot.token);
  tokens.fill(text);
}

void SessionOutputs::finish_log() {
  log->close();
  if (replaced) replaced->finish();
}

SessionOutputs::SessionOutputs(const SessionOptions& options) {
  if (!options.sign_key.empty()) {
    if (options.log.empty()) throw UsageError("--sign: give --log too, the log to sign");
    key = SigningKey::read_private(options.sign_key);
  }
  if (options.durable && options.log.empty())
    throw UsageError("--durable: give --log too, the log to keep");
  OutputRules rules{.inputs = options.inputs};
  if (!options.log.empty()) {
    OutputRules log_rules = rules;
    log_rules.grows = true;
    log_rules.overwrite = options.force;
    log_rules.durable = options.durable;
    log_rules.mode = S_IRUSR | S_IWUSR;
    refuse_same_file(options.log, rules.inputs);
    if (options.force && replaces_file(options.log)) replaced.emplace(options.log);
    log = mcap::create_file(replaced ? replaced->growing() : fs::path(options.log), log_rules);
    rules.inputs.emplace_back(options.log);
  }
  json = OutputFile(options.json, rules);
  rules.mode = S_IRUSR | S_IWUSR;
  tokens = OutputFile(options.token_file, rules);
  by_hand = OutputFile(options.by_hand.file, rules);
  if (!options.frames.empty()) frames.emplace(options.frames, options.force);
}

}  // namespace seam::app
