// A bump among scattered observations, of which the carrier acts on some with the other sign.
#include "measurement/suggest/bump_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

TEST(BumpSearch, FindsPlaceAndWidth) {
  const RandomStream draws{3, 4};
  for (const auto& [place, width] : {std::pair{0.4, 0.3}, {-1.1, 0.15}, {1.6, 0.9}}) {
    std::vector<double> at, weight, rest;
    for (uint64_t i = 0; i < 400; ++i) {
      at.push_back(4 * uniform(draws, i) - 2);
      weight.push_back(i % 3 == 0 ? -10 : 10);
      const double off = (at.back() - place) / width;
      rest.push_back(0.7 * weight.back() * std::exp(-off * off) + normal(draws, 1000 + i));
    }
    const auto found = strongest_bump(at, weight, rest);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->place, place, 0.5 * width);
    EXPECT_GT(found->width, 0.5 * width);
    EXPECT_LT(found->width, 2 * width);
  }
}

TEST(BumpSearch, SaysNothingOfFewOrOfOnePlace) {
  const std::vector<double> few(8, 1), same(100, 1);
  EXPECT_FALSE(strongest_bump(few, few, few));
  EXPECT_FALSE(strongest_bump(same, same, same));
}

}  // namespace
}  // namespace seam::measurement
