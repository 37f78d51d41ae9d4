// Looks at versions, one after another, in processes that give way to whatever a person asks for.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tools/workbench/child.h"

namespace seam::tools {

// One version to be looked at: commands, one after another, with their folder.
struct LookJob {
  uint64_t opened = 0;  // Of which session: versions of two may have one name.
  std::string version;
  std::filesystem::path folder;
  std::vector<std::vector<std::string>> commands;
};

class Looking {
 public:
  // What a command said on a line, and how the job ended: "" or what is wrong.
  using Said = std::function<void(const LookJob& job, const nlohmann::json& event)>;
  using Ended = std::function<void(const LookJob& job, const std::string& trouble, bool stopped)>;
  Looking(Said said, Ended ended);
  ~Looking();

  // Starts it, in place of any other.
  void want(LookJob job);
  // Ends whatever runs; a job that was wanted is forgotten.
  void cancel();
  // Runs one command while no look runs; `said` gets the events on its lines. Throws Refusal where
  // another such runs, or it was cancelled; InputError with its own words where it fails.
  void run_alone(const std::vector<std::string>& command, const std::filesystem::path& folder,
                 const std::function<void(const nlohmann::json&)>& said);
  bool runs(uint64_t opened, const std::string& version) const;

 private:
  void work();
  void run(const LookJob& job);

  const Said said_;
  const Ended ended_;
  Child child_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<LookJob> wanted_, running_;
  bool alone_ = false, cancelled_ = false, ending_ = false;
  bool over_ = false;  // What runs has ended; its results are being taken.
  std::jthread thread_;
};

}  // namespace seam::tools
