// One run of the scenario, as a process of its own: `seam serve` with robots that are driven. Wire,
// log and bits are those of any other client's run.
#pragma once

#include <signal.h>
#include <sys/types.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/scratch_folder.h"
#include "proto/line_stream.h"
#include "seam/v1/simulation.pb.h"

namespace seam::tools::dm {

// What all runs of this server have in common: `seam serve SCENARIO` with its options.
struct RunCommand {
  std::vector<std::string> words;
  std::string logs;  // Folder; empty: none.
};

// A robot's turns in a run.
class RobotLine {
 public:
  RobotLine(const std::string& path, const std::string& robot, const std::string& token);
  // Answers the newest observation.
  void answer(v1::Decision decision);
  // The next one; none at the end of the run. Throws RequestError where the line broke.
  std::optional<v1::Observation> next();
  // Why the server took the last answer for an empty one; empty: it did not.
  const std::string& refused() const { return refused_; }

 private:
  LineStream stream_;
  uint64_t sequence_ = 0;
  std::string refused_;
};

class Run {
 public:
  // Waits until it takes clients. `log`: the name of its log without folder; empty: none. Throws
  // RequestError with what the process said where it cannot run.
  Run(const RunCommand& command, int64_t seed, const std::string& log);
  ~Run();  // Ends it; its log is whole then.
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  std::unique_ptr<RobotLine> line_of(const std::string& robot) const;
  // Asks it to end.
  void stop() { send(SIGTERM); }
  // Of a run that has said goodbye: waits for its end. The exit code.
  int finish();
  // The end of what the process printed.
  std::string last_words() const;

 private:
  void watch(std::vector<std::string> words);
  void wait_for_end(pid_t pid, int output);
  bool wait_ended(double limit_s);
  void send(int signal);

  const app::ScratchFolder folder_{"dm-env-rpc"};
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  pid_t pid_ = -1;
  bool listening_ = false, ended_ = false;
  int exit_code_ = 1;
  std::string printed_;
  // The process ends with the thread that started it.
  std::jthread thread_;
};

}  // namespace seam::tools::dm
