#include "tools/viewer/kept_ends.h"

#include <gtest/gtest.h>

namespace seam::tools {
namespace {

TEST(KeptEnds, FromBothEndsOfALongListAndAllOfAShortOne) {
  const auto between = [](int before, uint64_t left_out) {
    return -before * 1000 - static_cast<int>(left_out);
  };
  KeptEnds<int> few(6), many(6);
  for (int i = 0; i < 6; ++i) few.push(i);
  EXPECT_EQ(few.left_out(), 0u);
  EXPECT_EQ(few.take(between), (std::vector<int>{0, 1, 2, 3, 4, 5}));
  for (int i = 0; i < 100; ++i) many.push(i);
  EXPECT_EQ(many.left_out(), 94u);
  EXPECT_EQ(many.take(between), (std::vector<int>{0, 1, 2, -2094, 97, 98, 99}));
}

}  // namespace
}  // namespace seam::tools
