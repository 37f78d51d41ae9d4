// The sums name the fields in which two states differ, and never others.
#include "scheduler/field_sums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sim_core/random.h"

namespace seam::scheduler {
namespace {

FieldSums sums_of(std::vector<double> values) {
  FieldSums sums;
  for (double& value : values) sums.field("", value);
  return sums;
}

std::vector<double> state(size_t fields) {
  std::vector<double> values(fields);
  for (size_t i = 0; i < fields; ++i) values[i] = uniform({1, 2}, i);
  return values;
}

TEST(FieldSums, FollowTheirDefinition) {
  // S_k = sum of h_i i^k modulo 2^31 - 1, with the hash of 1 as int64, written out.
  FieldSums sums;
  int64_t one = 1;
  sums.field("", one);
  sums.field("", one);
  uint64_t h = 1;
  h *= 0xff51afd7ed558ccdULL;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53ULL;
  h >>= 33;
  for (uint64_t k = 0; k < kFieldSums; ++k) {
    EXPECT_EQ(sums.sums()[k], (h + (h << k)) % 2147483647u) << k;
  }
}

TEST(FieldSums, NameUpToThreeFields) {
  constexpr size_t kFields = 1700;
  const std::vector<double> before = state(kFields);
  const FieldSums a = sums_of(before);
  EXPECT_TRUE(differing_fields(a.sums(), a.sums(), kFields).empty());
  for (uint64_t round = 0; round < 300; ++round) {
    std::set<size_t> wanted;
    for (uint64_t draw = 0; wanted.size() < 1 + round % 3; ++draw) {
      wanted.insert(random_bits({5, round}, draw)[0] % kFields);
    }
    std::vector<double> after = before;
    for (const size_t field : wanted) after[field] += 1e-9;
    const std::vector<size_t> found = differing_fields(a.sums(), sums_of(after).sums(), kFields);
    EXPECT_EQ(std::set<size_t>(found.begin(), found.end()), wanted) << round;
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  }
}

TEST(FieldSums, AreSilentWhereMoreDiffer) {
  constexpr size_t kFields = 1700;
  const std::vector<double> before = state(kFields);
  const FieldSums a = sums_of(before);
  for (size_t many = 4; many < 200; ++many) {
    std::vector<double> after = before;
    for (size_t i = 0; i < many; ++i) after[(i * 37) % kFields] += 1;
    EXPECT_TRUE(differing_fields(a.sums(), sums_of(after).sums(), kFields).empty()) << many;
  }
  EXPECT_TRUE(differing_fields({}, a.sums(), kFields).empty());
  // Hostile numbers beyond the prime are no more than other numbers.
  const std::vector<uint32_t> hostile(kFieldSums, 0xFFFFFFFF);
  EXPECT_TRUE(differing_fields(hostile, a.sums(), kFields).empty());
}

}  // namespace
}  // namespace seam::scheduler
