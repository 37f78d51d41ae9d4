// Makes frames on as many threads as the renderer has workers.
#pragma once

#include <condition_variable>
#include <deque>
#include <future>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "scheduler/loop/frame_renderer.h"

namespace seam::scheduler {

class RenderPool {
 public:
  explicit RenderPool(FrameRenderer& renderer);
  ~RenderPool();  // Drops what has not begun.
  RenderPool(const RenderPool&) = delete;
  RenderPool& operator=(const RenderPool&) = delete;

  // The job must live until the future is ready; an error of the renderer comes out of it.
  std::future<Frame> submit(int robot, const FrameJob& job);

 private:
  void work(int worker);
  void end();

  FrameRenderer& renderer_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::packaged_task<Frame(int)>> queue_;
  bool ending_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace seam::scheduler
