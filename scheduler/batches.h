// Work that is done in another thread, in order, a batch at a time: what must not slow the caller.
#pragma once

#include <functional>
#include <future>
#include <utility>
#include <vector>

namespace seam::scheduler {

// At most two batches exist, one being done and one being gathered. What is gathered when it is
// destroyed is not done.
class Batches {
 public:
  using Task = std::function<void()>;

  // Tasks may use what the caller does not touch until `finish`.
  void add(Task task) { gathered_.push_back(std::move(task)); }

  // Starts what was gathered, after the batch before. Throws what a task of that one threw.
  void start() {
    finish_started();
    started_ = std::async(std::launch::async, [tasks = std::exchange(gathered_, {})] {
      for (const Task& task : tasks) task();
    });
  }

  // Returns when all is done. Throws what a task threw.
  void finish() {
    start();
    finish_started();
  }

 private:
  void finish_started() {
    if (started_.valid()) started_.get();
  }

  std::vector<Task> gathered_;
  std::future<void> started_;  // Its destructor waits.
};

}  // namespace seam::scheduler
