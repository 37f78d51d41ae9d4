// Numbered jobs whose results are texts, done by worker processes; where there is a file for them,
// an SQLite file keeps each result as it comes, so that the same command goes on after an
// interruption, whatever ended it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "app/sweep/database.h"

namespace seam::app {

struct JobsOptions {
  std::filesystem::path file;  // Empty: nothing is kept.
  std::string format;          // Of the file, such as "seam-study-results/1".
  std::string made_of;        // All that results depend on beside their number: others are refused.
  const char* what = "jobs";  // For people.
  int workers = 0;            // 0: one for each core.
};

class KeptJobs {
 public:
  explicit KeptJobs(JobsOptions options);
  ~KeptJobs();
  KeptJobs(const KeptJobs&) = delete;
  KeptJobs& operator=(const KeptJobs&) = delete;

  // Jobs `first` to `last`, without it. `work` is called in a worker, which must not depend on the
  // jobs before; `done` in this process, which must have no other thread, in any order. False after
  // SIGINT, SIGTERM or SIGHUP: what is done is kept. Throws InputError with the message of a job
  // that throws, for a file of something else, or one that another process writes.
  bool run(uint64_t first, uint64_t last, const std::function<std::string(uint64_t)>& work,
           const std::function<void(uint64_t, const std::string&)>& done);

  // Of this machine, for the threads of each worker of the run that goes on.
  size_t cores_each() const { return cores_each_; }

 private:
  void open();

  JobsOptions options_;
  OwnedDatabase kept_;
  size_t cores_each_ = 1;
};

}  // namespace seam::app
