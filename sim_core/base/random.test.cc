#include "sim_core/base/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace seam {
namespace {

const RandomStream kStream{1, 2};

TEST(Random, IsAPureFunctionWithAGoldenValue) {
  // Philox4x32-10 of counter 0 and key 0: the known answer of Random123's own test vectors.
  const auto bits = random_bits({0, 0}, 0);
  EXPECT_EQ(bits[0], 0x6627e8d5u);
  EXPECT_EQ(bits[1], 0xe169c58du);
  EXPECT_EQ(bits[2], 0xbc57ac4cu);
  EXPECT_EQ(bits[3], 0x9b00dbd8u);
}

TEST(Random, ChildrenAreDifferentStreams) {
  EXPECT_NE(kStream.child("a").stream, kStream.child("b").stream);
  EXPECT_NE(kStream.child(uint64_t{1}).stream, kStream.child(uint64_t{2}).stream);
  EXPECT_NE(kStream.child("a").child("b").stream, kStream.child("b").child("a").stream);
}

TEST(Random, NormalMoments) {
  // 5 standard errors of each moment at n = 200,000: a false alarm in about 10^6 streams.
  const int n = 200000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0, lag = 0, last = 0;
  for (int i = 0; i < n; ++i) {
    const double x = normal(kStream, i);
    m1 += x, m2 += x * x, m3 += x * x * x, m4 += x * x * x * x;
    lag += x * last;
    last = x;
  }
  const double se = 5 / std::sqrt(n);
  EXPECT_NEAR(m1 / n, 0, se);
  EXPECT_NEAR(m2 / n, 1, se * std::sqrt(2));
  EXPECT_NEAR(m3 / n, 0, se * std::sqrt(15));
  EXPECT_NEAR(m4 / n, 3, se * std::sqrt(96));
  EXPECT_NEAR(lag / n, 0, se);
}

class Poisson : public testing::TestWithParam<double> {};

TEST_P(Poisson, HasTheExactProbabilities) {
  const double mean = GetParam();
  const int n = 200000;
  std::vector<int> count(2000);
  for (int i = 0; i < n; ++i) ++count.at(poisson(kStream, i, mean));
  // Chi-square over the cells with 10 or more expected; its own spread is sqrt(2 cells).
  double chi2 = 0;
  int cells = 0;
  for (int k = 0; k < 2000; ++k) {
    const double expected = n * std::exp(k * std::log(mean) - mean - std::lgamma(k + 1.0));
    if (expected < 10) continue;
    chi2 += (count[k] - expected) * (count[k] - expected) / expected;
    ++cells;
  }
  EXPECT_LT(chi2, cells + 5 * std::sqrt(2.0 * cells));
}

INSTANTIATE_TEST_SUITE_P(Means, Poisson, testing::Values(0.3, 4.0, 29.9, 30.1, 75.0, 400.0));

}  // namespace
}  // namespace seam
