#include "measurement/numerics/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace seam::measurement {
namespace {

using std::chrono::milliseconds;

class ParallelFor : public testing::Test {
 protected:
  ParallelFor() { use_threads(2); }
  ~ParallelFor() override { use_threads(0); }
};

TEST_F(ParallelFor, RunsEachJobOnce) {
  std::vector<std::atomic<int>> runs(1000);
  parallel_for(runs.size(), [&](size_t i) { ++runs[i]; });
  for (const auto& count : runs) EXPECT_EQ(count, 1);
  parallel_for(0, [](size_t) { FAIL(); });
}

TEST_F(ParallelFor, RethrowsAndStillRunsTheOthers) {
  std::atomic<int> runs{0};
  const auto job = [&](size_t i) {
    ++runs;
    if (i == 3) throw std::runtime_error("the third");
  };
  EXPECT_THROW(parallel_for(10, job), std::runtime_error);
  EXPECT_EQ(runs, 10);
}

TEST_F(ParallelFor, LoopsInsideOfLoopsShareTheCores) {
  std::atomic<int> running{0}, most{0};
  parallel_for(4, [&](size_t) {
    parallel_for(4, [&](size_t) {
      const int now = ++running;
      for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) continue;
      std::this_thread::sleep_for(milliseconds(1));
      --running;
    });
  });
  EXPECT_EQ(most, 2);
}

// Few jobs of unequal length: the last one's own loop has the core of those that have ended,
// whichever thread has it.
TEST_F(ParallelFor, ALoopInsideHasTheCoreThatTheOuterOneLeaves) {
  for (const size_t longest : {0, 1}) {
    std::mutex mutex;
    std::set<std::thread::id> threads;
    std::atomic<int> begun{0};
    parallel_for(2, [&](size_t job) {
      // Each has a thread: the caller's takes the first.
      for (++begun; begun < 2;) std::this_thread::yield();
      if (job != longest) return;
      std::this_thread::sleep_for(milliseconds(20));
      parallel_for(200, [&](size_t) {
        std::this_thread::sleep_for(milliseconds(1));
        const std::lock_guard lock(mutex);
        threads.insert(std::this_thread::get_id());
      });
    });
    EXPECT_GE(threads.size(), 2u) << longest;
  }
}

}  // namespace
}  // namespace seam::measurement
