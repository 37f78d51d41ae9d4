#include "app/terminal_progress.h"

#include <gtest/gtest.h>

namespace seam::app {
namespace {

TEST(TerminalProgress, APartWithoutCountsShowsItsLabelAlone) {
  EXPECT_EQ(progress_text({.label = "reading the set", .steps = 0}, 0.4, 0.4),
            "1 s reading the set (0 steps of fits)");
}

TEST(TerminalProgress, TimeLeftIsThatOfThePiecesDone) {
  WorkTally::Seen seen{
      .label = "step 2", .part = "candidates", .done = 3, .of = 9, .at_most = true, .steps = 40};
  EXPECT_EQ(progress_text(seen, 12, 4),  // 4 s for 3 pieces, and 6 to come.
            "12 s step 2: candidates 3 of at most 9, at most 8 s left (40 steps of fits)");
  seen.at_most = false;
  EXPECT_EQ(progress_text(seen, 12, 4),
            "12 s step 2: candidates 3 of 9, about 8 s left (40 steps of fits)");
}

TEST(TerminalProgress, NoEstimateBeforeAPieceIsDoneOrASecondHasPassed) {
  WorkTally::Seen seen{.label = "step 2", .part = "candidates", .done = 0, .of = 9};
  EXPECT_EQ(progress_text(seen, 12, 4), "12 s step 2: candidates 0 of 9 (0 steps of fits)");
  seen.done = 2;
  EXPECT_EQ(progress_text(seen, 12, 0.5), "12 s step 2: candidates 2 of 9 (0 steps of fits)");
}

}  // namespace
}  // namespace seam::app
