// What a run writes, claimed before anything starts: a path that cannot be written, that another
// run writes or that is read meanwhile is an error at once.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/session/frame_files.h"
#include "app/session/run_session.h"
#include "app/trust/log_signature.h"
#include "mcap/io.h"
#include "sim_core/base/output.h"

namespace seam::app {

// A log that is there and is to be overwritten: it stays until the new one, which grows beside it,
// is whole. Nobody else writes it meanwhile.
class ReplacedLog {
 public:
  // Throws InputError where another run writes it.
  explicit ReplacedLog(const std::filesystem::path& log);
  ~ReplacedLog();  // Without `finish` the new log goes. A killed process leaves both.
  ReplacedLog(const ReplacedLog&) = delete;
  ReplacedLog& operator=(const ReplacedLog&) = delete;

  const std::filesystem::path& growing() const { return growing_; }
  void finish();

 private:
  std::filesystem::path log_, growing_;
  int lock_ = -1;
};

struct SessionOutputs {
  // Throws InputError and UsageError.
  explicit SessionOutputs(const SessionOptions& options);

  // Secrets for clients elsewhere, where they are asked for.
  void fill_tokens(const std::vector<scheduler::HubRobot>& robots, const std::string& supervisor,
                   const std::string& render);
  // The log is complete; throws InputError where it cannot be.
  void finish_log();

  std::optional<ReplacedLog> replaced;
  std::unique_ptr<mcap::Output> log;  // None: not asked for.
  std::optional<SigningKey> key;      // Signs the log when it is whole.
  std::optional<FrameFiles> frames;
  OutputFile json;
  OutputFile tokens, by_hand;  // Readable by this user alone.
};

}  // namespace seam::app
