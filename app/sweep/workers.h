// Jobs done by worker processes: forked from this one, which must have no other thread, so that a
// job which ends its process takes no other with it, and all that was read before is theirs.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace seam::app {

struct WorkerCalls {
  // In this process. The next job, or nothing when no more are to be begun.
  std::function<std::optional<uint64_t>()> next;
  // In a worker: the job's result; an empty text where a signal stopped it.
  std::function<std::string(uint64_t job)> work;
  // In this process, in the order in which jobs end.
  std::function<void(uint64_t job, const std::string& result)> done;
  // The worker died in this job: how, and the last that it wrote.
  std::function<void(uint64_t job, const std::string& how)> died;
  std::function<void()> tick;  // A few times a second.
};

// Of this machine, as threads may use them.
int machine_cores();
// What is left to each of so many workers for threads of its own.
int cores_for_each(int workers);

// Returns when all jobs are done, or false after SIGINT, SIGTERM or SIGHUP, which ends the workers
// and what they started. Whatever a call throws ends them, too.
bool run_in_workers(int workers, const WorkerCalls& calls);

}  // namespace seam::app
