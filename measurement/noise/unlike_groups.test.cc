#include "measurement/noise/unlike_groups.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim_core/base/random.h"

namespace seam::measurement {
namespace {

// Groups of so many normal values whose sigmas are lognormal with this spread.
std::vector<ResidualGroup> made(size_t count, size_t values, double spread, uint64_t seed,
                                std::vector<double>* sigmas = nullptr) {
  std::vector<ResidualGroup> groups(count);
  uint64_t draw = 0;
  for (size_t g = 0; g < count; ++g) {
    const double sigma = 0.3 * std::exp(spread * normal({seed, 1}, g));
    if (sigmas) sigmas->push_back(sigma);
    for (size_t i = 0; i < values; ++i)
      groups[g].values.push_back(sigma * normal({seed, 2}, draw++));
    groups[g].freedom = static_cast<double>(values);
  }
  return groups;
}

TEST(UnlikeGroups, ThatDifferByChanceAreAlike) {
  int unlike = 0;
  for (uint64_t seed = 0; seed < 400; ++seed)
    unlike += !spreads_of_groups(made(15, 60, 0, seed)).empty();
  EXPECT_LE(unlike, 3);  // 0.4 expected.
}

// Told sigmas are nearer to the true ones than each group's own is, and scatter as these do.
TEST(UnlikeGroups, AreToldApartAsFarAsChanceAllows) {
  constexpr double kSpread = 0.3;
  double own2 = 0, told2 = 0, size2 = 0, count = 0;
  for (uint64_t seed = 0; seed < 50; ++seed) {
    std::vector<double> sigmas;
    const auto groups = made(40, 30, kSpread, seed, &sigmas);
    const auto spreads = spreads_of_groups(groups);
    ASSERT_EQ(spreads.size(), sigmas.size()) << seed;
    double typical = 0;
    for (size_t g = 0; g < sigmas.size(); ++g)
      typical += std::log(sigmas[g] / spreads[g]) / static_cast<double>(sigmas.size());
    for (size_t g = 0; g < sigmas.size(); ++g) {
      double square = 0;
      for (const double value : groups[g].values) square += value * value;
      const double own = 0.5 * std::log(square / groups[g].freedom), log = std::log(sigmas[g]);
      own2 += std::pow(own - log, 2), told2 += std::pow(std::log(spreads[g]) + typical - log, 2);
      size2 += std::pow(std::log(spreads[g]), 2), ++count;
    }
  }
  EXPECT_LT(told2, 0.95 * own2);
  // A normal value of which noise of 1 / (2 * 30) was added scatters, drawn back, by the square
  // root of its share less.
  const double share = kSpread * kSpread / (kSpread * kSpread + 1.0 / 60);
  EXPECT_NEAR(std::sqrt(size2 / count), kSpread * std::sqrt(share), 0.02);
}

TEST(UnlikeGroups, OfFewNothingIsTold) {
  EXPECT_TRUE(spreads_of_groups(made(3, 200, 1, 7)).empty());
  EXPECT_TRUE(spreads_of_groups({}).empty());
}

// Some far values make no group unlike: each has them now and then.
TEST(UnlikeGroups, FarValuesAreNoScatterOfAGroup) {
  int unlike = 0;
  for (uint64_t seed = 0; seed < 100; ++seed) {
    auto groups = made(15, 100, 0, seed);
    uint64_t draw = 0;
    for (ResidualGroup& group : groups) {
      for (double& value : group.values) {
        if (uniform({seed, 3}, draw++) < 0.05) value *= 8;
      }
    }
    unlike += !spreads_of_groups(groups).empty();
  }
  EXPECT_LE(unlike, 8);  // Of 100; by plain variances all of them are.
}

// Where a part of the values has a wider spread groups have more or fewer of these, and are alike.
TEST(UnlikeGroups, AMixtureIsNoScatterOfGroups) {
  auto groups = made(18, 700, 0, 5);
  uint64_t draw = 0;
  for (size_t g = 0; g < groups.size(); ++g) {
    const double share = g % 3 == 0 ? 0.4 : 0.1;
    for (double& value : groups[g].values) {
      if (uniform({5, 3}, draw++) < share) value *= 5;
    }
  }
  EXPECT_TRUE(spreads_of_groups(groups).empty());
}

}  // namespace
}  // namespace seam::measurement
