#include "tools/work_lines.h"

#include <gtest/gtest.h>

namespace seam::tools {
namespace {

TEST(WorkLines, SayWhatGoesOnAndHowFarItIs) {
  EXPECT_EQ(work_line({.label = "reading the set", .steps = 4}),
            R"({"doing":"reading the set","done":0,"event":"work","of":0})");
  EXPECT_EQ(work_line({.label = "planning", .part = "effects planned", .done = 3, .of = 9}),
            R"({"doing":"planning: effects planned","done":3,"event":"work","of":9})");
  EXPECT_EQ(work_line({.part = "pictures", .done = 3, .of = 9}),
            R"({"doing":"pictures","done":3,"event":"work","of":9})");
  // A name of a file may be any bytes.
  EXPECT_EQ(work_line({.label = "\xff"}), R"({"doing":")"
                                          "\xef\xbf\xbd"
                                          R"(","done":0,"event":"work","of":0})");
}

}  // namespace
}  // namespace seam::tools
