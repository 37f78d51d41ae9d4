#include "sim_core/system/work_tally.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace seam {
namespace {

TEST(WorkTally, CountsTheOutermostPart) {
  { const Work unseen("unseen", 3); }  // Nobody watches.
  WorkTally tally;
  watch_work(&tally);
  say_work("trying effects");
  {
    const Work outer("effects", 3);
    outer.done();
    const Work inner("steps", 40, Work::Of::at_most);
    inner.done(), inner.done();
    count_fit_step();
    const WorkTally::Seen seen = tally.seen();
    EXPECT_EQ(seen.label, "trying effects");
    EXPECT_EQ(seen.part, "effects");
    EXPECT_EQ(seen.done, 1u);
    EXPECT_EQ(seen.of, 3u);
    EXPECT_EQ(seen.steps, 1u);
    EXPECT_FALSE(seen.at_most);
  }
  EXPECT_EQ(tally.seen().part, "");
  const Work next("steps", 40, Work::Of::at_most);
  EXPECT_EQ(tally.seen().number, 2u);
  EXPECT_EQ(tally.seen().done, 0u);
  EXPECT_TRUE(tally.seen().at_most);
  watch_work(nullptr);
  next.done();  // The part that it counts is still there.
  EXPECT_EQ(tally.seen().done, 1u);
}

TEST(WorkTally, CountsFromManyThreads) {
  WorkTally tally;
  watch_work(&tally);
  {
    const Work work("pieces", 4000);
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 1000; ++i) work.done(), count_fit_step();
      });
    }
    threads.clear();
    EXPECT_EQ(tally.seen().done, 4000u);
  }
  EXPECT_EQ(tally.seen().steps, 4000u);
  watch_work(nullptr);
}

}  // namespace
}  // namespace seam
