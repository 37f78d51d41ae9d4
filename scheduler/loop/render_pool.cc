#include "scheduler/loop/render_pool.h"

namespace seam::scheduler {

RenderPool::RenderPool(FrameRenderer& renderer) : renderer_(renderer) {
  for (int worker = 0; worker < renderer.workers(); ++worker)
    threads_.emplace_back([this, worker] { work(worker); });
}

RenderPool::~RenderPool() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    queue_.clear();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

std::future<Frame> RenderPool::submit(int robot, const FrameJob& job) {
  std::packaged_task<Frame(int)> task(
      [this, robot, &job](int worker) { return renderer_.render(robot, job, worker); });
  std::future<Frame> future = task.get_future();
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(task));
  }
  changed_.notify_one();
  return future;
}

void RenderPool::work(int worker) {
  while (true) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return ending_ || !queue_.empty(); });
    if (ending_) return;
    auto task = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    task(worker);
  }
}

}  // namespace seam::scheduler
