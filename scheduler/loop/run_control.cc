#include "scheduler/loop/run_control.h"

namespace seam::scheduler {

void RunControl::want(std::unique_lock<std::mutex>& lock) {
  wanted_.store(true, std::memory_order_release);
  changed_.notify_all();
  const std::function<void()> waker = waker_;
  lock.unlock();
  if (waker) waker();
}

void RunControl::stop() {
  std::unique_lock lock(mutex_);
  stop_ = true;
  want(lock);
}

void RunControl::pause() {
  std::unique_lock lock(mutex_);
  paused_ = true;
  run_until_.reset();
  want(lock);
}

void RunControl::resume() {
  std::unique_lock lock(mutex_);
  paused_ = false;
  run_until_.reset();
  want(lock);
}

void RunControl::step(SimDuration duration) {
  std::unique_lock lock(mutex_);
  step_asked_ = step_asked_ + duration;
  want(lock);
}

bool RunControl::paused() const {
  std::unique_lock lock(mutex_);
  return paused_;
}

void RunControl::post(Task task) {
  std::unique_lock lock(mutex_);
  if (closed_) {
    lock.unlock();
    return task(false);
  }
  tasks_.push_back(std::move(task));
  want(lock);
}

void RunControl::post_when_standing(Task task) {
  std::unique_lock lock(mutex_);
  if (closed_) {
    lock.unlock();
    return task(false);
  }
  tasks_when_standing_.push_back(std::move(task));
  want(lock);
}

void RunControl::serve_all(std::deque<Task>& tasks, std::unique_lock<std::mutex>& lock,
                           bool running) {
  while (!tasks.empty()) {
    const Task task = std::move(tasks.front());
    tasks.pop_front();
    lock.unlock();
    task(running);
    lock.lock();
  }
}

void RunControl::serve() {
  std::unique_lock lock(mutex_);
  serve_all(tasks_, lock, true);
}

bool RunControl::poll(SimTime now, SimTime next) {
  if (!wanted()) {
    time_ns_.store(next.ns(), std::memory_order_relaxed);
    return true;
  }
  std::unique_lock lock(mutex_);
  while (true) {
    serve_all(tasks_, lock, true);
    if (stop_) return false;
    if (!paused_) {
      step_asked_ = {};
      wanted_ = !tasks_when_standing_.empty();
      break;
    }
    if (step_asked_.ns() > 0) {
      run_until_ = run_until_.value_or(now) + step_asked_;
      step_asked_ = {};
    }
    if (run_until_ && next <= *run_until_) break;
    if (!tasks_when_standing_.empty()) {
      serve_all(tasks_when_standing_, lock, true);
      continue;  // Much may have changed meanwhile.
    }
    changed_.wait(lock);
  }
  time_ns_.store(next.ns(), std::memory_order_relaxed);
  return true;
}

void RunControl::set_waker(std::function<void()> waker) {
  std::unique_lock lock(mutex_);
  waker_ = std::move(waker);
}

void RunControl::close() {
  std::unique_lock lock(mutex_);
  closed_ = true;
  waker_ = nullptr;
  serve_all(tasks_, lock, false);
  serve_all(tasks_when_standing_, lock, false);
}

}  // namespace seam::scheduler
