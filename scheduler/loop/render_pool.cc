#include "scheduler/loop/render_pool.h"

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

namespace seam::scheduler {

RenderPool::RenderPool(FrameRenderer& renderer) : renderer_(renderer) {
  try {
    for (int worker = 0; worker < renderer.workers(); ++worker)
      threads_.push_back(start_thread([this, worker] { work(worker); }));
  } catch (const InputError&) {
    end();
    throw;
  }
}

RenderPool::~RenderPool() {
  end();
}

void RenderPool::end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    queue_.clear();
  }
  changed_.notify_all();
  threads_.clear();  // Joins them.
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
