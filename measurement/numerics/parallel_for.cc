#include "measurement/numerics/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

namespace seam::measurement {
namespace {

size_t most_threads = 0;  // 0: one for each core.

}  // namespace

void use_threads(size_t most) {
  most_threads = most;
}

void parallel_for(size_t count, const std::function<void(size_t)>& job, bool worth_threads) {
  const size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const size_t most = most_threads > 0 ? most_threads : cores;
  const size_t workers = std::min(count, worth_threads ? most : 1);
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto work = [&] {
    for (size_t i = next++; i < count; i = next++) {
      try {
        job(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    try {
      for (size_t w = 1; w < workers; ++w) threads.push_back(start_thread(work));
    } catch (const InputError&) {
      next = count;  // Those that were started end with the job they have.
      throw;
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace seam::measurement
