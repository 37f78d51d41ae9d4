// How the outside steers a run: stop, pause, step, and questions about its state. Calls come from
// any thread and return at once; all is served by the loop's thread between two events of
// simulated time, so that a question is answered from one consistent state.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>

#include "sim_core/base/time.h"

namespace seam::scheduler {

class RunControl {
 public:
  // A question; called on the loop's thread with true, or with false when the run is over.
  using Task = std::function<void(bool running)>;

  // ---- From any thread ----

  // Ends the run cleanly before the next event.
  void stop();
  bool stop_requested() const { return stop_.load(std::memory_order_relaxed); }
  void pause();
  void resume();
  // While paused: lets the run go on for this long.
  void step(SimDuration duration);
  bool paused() const;
  // Serves the task at the next chance, also while the loop waits for clients.
  void post(Task task);
  // Serves the task once the run stands still because it is paused and its steps are done.
  void post_when_standing(Task task);

  // ---- From the loop ----

  // Serves what was posted, and blocks while paused before `next`, the time of the next event,
  // which then becomes time(). False when the run is to stop. Cheap when nobody wants anything.
  bool poll(SimTime now, SimTime next);
  // Serves what was posted without blocking; for whoever blocks the loop's thread otherwise.
  void serve();
  bool wanted() const { return wanted_.load(std::memory_order_acquire); }
  // Called whenever something is wanted, so that a blocked loop wakes up.
  void set_waker(std::function<void()> waker);
  // The run is over: every waiting and later task is called with false.
  void close();
  SimTime time() const { return SimTime::from_ns(time_ns_.load(std::memory_order_relaxed)); }
  void count_frame() { frames_.fetch_add(1, std::memory_order_relaxed); }
  uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }

 private:
  void want(std::unique_lock<std::mutex>& lock);
  void serve_all(std::deque<Task>& tasks, std::unique_lock<std::mutex>& lock, bool running);

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  std::deque<Task> tasks_when_standing_;
  std::function<void()> waker_;
  std::atomic<bool> stop_ = false;
  std::atomic<bool> wanted_ = false;
  std::atomic<int64_t> time_ns_ = 0;
  std::atomic<uint64_t> frames_ = 0;  // Finished since the start.
  bool paused_ = false;
  bool closed_ = false;
  SimDuration step_asked_;            // Not yet added to run_until_.
  std::optional<SimTime> run_until_;  // While paused: events up to here may happen.
};

}  // namespace seam::scheduler
