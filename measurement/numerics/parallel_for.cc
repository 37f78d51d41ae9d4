#include "measurement/numerics/parallel_for.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "sim_core/base/error.h"
#include "sim_core/system/thread.h"

namespace seam::measurement {
namespace {

size_t most_threads = 0;  // 0: one for each core.
// Threads at work beside one that called, of all loops; who waits for helpers is not at work.
std::atomic<std::ptrdiff_t> helpers{0};

// A core that no loop uses: loops inside of loops have those that the outer ones leave idle.
class IdleCore {
 public:
  IdleCore() {
    const auto cores = static_cast<std::ptrdiff_t>(
        most_threads > 0 ? most_threads : std::thread::hardware_concurrency());
    for (std::ptrdiff_t now = helpers; !found_ && now + 1 < cores;)
      found_ = helpers.compare_exchange_weak(now, now + 1);
  }
  ~IdleCore() {
    if (found_) --helpers;
  }
  IdleCore(IdleCore&& from) noexcept : found_(std::exchange(from.found_, false)) {}
  IdleCore(const IdleCore&) = delete;
  IdleCore& operator=(const IdleCore&) = delete;
  IdleCore& operator=(IdleCore&&) = delete;

  bool found() const { return found_; }

 private:
  bool found_ = false;
};

}  // namespace

void use_threads(size_t most) {
  most_threads = most;
}

void parallel_for(size_t count, const std::function<void(size_t)>& job, bool worth_threads) {
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex mutex;
  const auto run = [&](size_t i) {
    try {
      job(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;
    // Cores that become idle later help from then on.
    const auto call_helpers = [&] {
      while (next < count) {
        auto core = std::make_shared<IdleCore>();
        if (!core->found()) return;
        threads.push_back(start_thread([&, core = std::move(core)]() mutable {
          for (size_t i = next++; i < count; i = next++) run(i);
          core.reset();  // Before the thread is joined.
        }));
      }
    };
    try {
      for (size_t i = next++; i < count; i = next++) {
        if (worth_threads) call_helpers();
        run(i);
      }
    } catch (const InputError&) {
      next = count;  // Those that were started end with the job they have.
      throw;
    }
    // The core of this thread, too, is for what the last jobs hold.
    --helpers;
    threads.clear();
    ++helpers;
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace seam::measurement
