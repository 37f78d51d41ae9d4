#include "scheduler/log/batches.h"

#include "sim_core/system/thread.h"

namespace seam::scheduler {

Batches::~Batches() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (worker_.joinable()) worker_.join();
}

void Batches::wait_for_worker(std::unique_lock<std::mutex>& lock) {
  changed_.wait(lock, [&] { return !busy_; });
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Batches::start() {
  std::unique_lock lock(mutex_);
  wait_for_worker(lock);
  if (!worker_.joinable()) worker_ = start_thread([this] { work(); });
  batch_.swap(gathered_);
  busy_ = true;
  lock.unlock();
  changed_.notify_all();
}

void Batches::finish() {
  start();
  std::unique_lock lock(mutex_);
  wait_for_worker(lock);
}

void Batches::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return busy_ || ending_; });
    if (!busy_) return;
    lock.unlock();
    std::exception_ptr failure;
    try {
      for (const Task& task : batch_) task();
    } catch (...) {
      failure = std::current_exception();
    }
    batch_.clear();
    lock.lock();
    failure_ = failure;
    busy_ = false;
    changed_.notify_all();
  }
}

}  // namespace seam::scheduler
