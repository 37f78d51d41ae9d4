#include "scheduler/log/batches.h"

#include <gtest/gtest.h>

#include <numeric>
#include <stdexcept>

namespace seam::scheduler {
namespace {

TEST(Batches, AreDoneInOrder) {
  std::vector<int> done;
  Batches batches;
  for (int i = 0; i < 1000; ++i) {
    batches.add([&done, i] { done.push_back(i); });
    if (i % 7 == 0) batches.start();
  }
  batches.finish();
  std::vector<int> all(1000);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(done, all);
}

TEST(Batches, ThrowWhatATaskThrewAndGoOn) {
  Batches batches;
  int done = 0;
  batches.add([] { throw std::runtime_error("the disk is full"); });
  batches.start();
  batches.add([&done] { ++done; });
  EXPECT_THROW(batches.start(), std::runtime_error);
  batches.finish();
  EXPECT_EQ(done, 1);
}

TEST(Batches, EndWithWhatWasStarted) {
  int done = 0;
  {
    Batches batches;
    batches.add([&done] { ++done; });
    batches.start();
    batches.add([&done] { done = 100; });
  }
  EXPECT_EQ(done, 1);
}

}  // namespace
}  // namespace seam::scheduler
