// Work that is done in another thread, in order, a batch at a time: what must not slow the caller.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace seam::scheduler {

// At most two batches exist, one being done and one being gathered. What is gathered when it is
// destroyed is not done.
class Batches {
 public:
  using Task = std::function<void()>;

  Batches() = default;
  Batches(const Batches&) = delete;
  Batches& operator=(const Batches&) = delete;
  ~Batches();

  // Tasks may use what the caller does not touch until `finish`.
  void add(Task task) { gathered_.push_back(std::move(task)); }
  // Starts what was gathered, after the batch before. Throws what a task of that one threw.
  void start();
  // Returns when all is done. Throws what a task threw.
  void finish();

 private:
  void work();
  void wait_for_worker(std::unique_lock<std::mutex>& lock);

  std::vector<Task> gathered_;  // The caller's.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Task> batch_;
  bool busy_ = false, ending_ = false;
  std::exception_ptr failure_;
  std::jthread worker_;  // One for all batches: a new one each time would spread memory over
                         // malloc's arenas.
};

}  // namespace seam::scheduler
