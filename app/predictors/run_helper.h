// A process forked from this one that answers requests. The engine of sweeps forks its workers from
// a process of one thread; a search has several, so it asks this one.
#pragma once

#include <sys/types.h>

#include <functional>
#include <mutex>
#include <string>

namespace seam::app {

class RunHelper {
 public:
  // `answer` runs in the helper, which has all that was read before; what it throws becomes an
  // InputError of `ask`. Must be made while this process has one thread.
  explicit RunHelper(const std::function<std::string(const std::string& request)>& answer);
  ~RunHelper();
  RunHelper(const RunHelper&) = delete;
  RunHelper& operator=(const RunHelper&) = delete;

  // Thread-safe: one request after another. Throws InputError, also where the helper has ended.
  std::string ask(const std::string& request);

 private:
  std::mutex mutex_;
  int socket_ = -1;
  pid_t process_ = -1;
};

}  // namespace seam::app
