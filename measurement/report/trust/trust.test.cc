#include "measurement/report/trust/trust.h"

#include <gtest/gtest.h>

#include "measurement/report/trust/trust_table.h"

namespace seam::measurement {
namespace {

TEST(Trust, IsWhatTheBenchmarksTableSays) {
  for (const TrustRow& row : kTrust) {
    ASSERT_LE(row.right, row.sets) << row.kind;
    const auto trust = trust_in(row.kind, row.verdict);
    if (!trust) continue;
    EXPECT_EQ(trust->right.hits, row.right);
    const double share = static_cast<double>(row.right) / row.sets;
    constexpr double kRounding = 1e-12;
    EXPECT_LE(trust->right.low(), share + kRounding);
    EXPECT_GE(trust->right.high(), share - kRounding);
    EXPECT_NE(trust_text(trust).find(std::to_string(row.right) + " were right"), std::string::npos);
  }
}

TEST(Trust, SaysNothingOfWhatTheBenchmarkLacks) {
  EXPECT_FALSE(trust_in("frames", "named"));
  EXPECT_EQ(trust_text(std::nullopt), "");
}

// Where all were right, Wilson's interval is n / (n + z^2) to 1.
TEST(Trust, HasWilsonsInterval) {
  int perfect = 0;
  for (const TrustRow& row : kTrust) {
    const auto trust = trust_in(row.kind, row.verdict);
    if (!trust || row.right != row.sets) continue;
    ++perfect;
    EXPECT_NEAR(trust->right.low(), row.sets / (row.sets + 3.8415), 1e-4) << row.kind;
    EXPECT_NEAR(trust->right.high(), 1, 1e-9) << row.kind;
  }
  EXPECT_GT(perfect, 0);
}

}  // namespace
}  // namespace seam::measurement
