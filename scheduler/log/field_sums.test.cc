// The sums name the fields in which two states differ, and never others.
#include "scheduler/log/field_sums.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "sim_core/base/random.h"
#include "sim_core/body/state.h"

namespace seam::scheduler {
namespace {

std::vector<uint32_t> sums_of(std::vector<double> values) {
  StateWords words;
  for (double& value : values) words.field("", value);
  return FieldSums().of(words.words());
}

std::vector<double> state(size_t fields) {
  std::vector<double> values(fields);
  for (size_t i = 0; i < fields; ++i) values[i] = uniform({1, 2}, i);
  return values;
}

TEST(FieldSums, FollowTheirDefinition) {
  // S_k = sum of h_i i^k modulo 2^31 - 1, term by term; many fields, so that blocks end within and
  // at the state's end.
  for (const size_t fields : {1, 2, 31, 32, 33, 500, 4096}) {
    std::vector<int64_t> words(fields, -1);
    for (size_t i = 0; i + 1 < fields; ++i)
      words[i] = static_cast<int64_t>(random_bits({7, 7}, i)[0]) << (i % 40);
    const std::vector<uint32_t> sums = FieldSums().of(words);
    ASSERT_EQ(sums.size(), kFieldSums);
    for (size_t k = 0; k < kFieldSums; ++k) {
      uint64_t expected = 0;
      for (size_t i = 0; i < fields; ++i) {
        auto h = static_cast<uint64_t>(words[i]);
        h = (h ^ (h >> 33)) * 0xff51afd7ed558ccdULL;
        h = (h ^ (h >> 33)) * 0xc4ceb9fe1a85ec53ULL;
        uint64_t term = h >> 33;
        for (size_t power = 0; power < k; ++power) term = term * (i + 1) % 2147483647u;
        expected = (expected + term) % 2147483647u;
      }
      EXPECT_EQ(sums[k], expected) << fields << " fields, power " << k;
    }
  }
}

TEST(FieldSums, OfAStateDoNotDependOnTheStateBefore) {
  std::vector<int64_t> words(700, 5);
  FieldSums sums;
  for (uint64_t step = 0; step < 200; ++step) {
    if (step == 100) words.resize(333);  // Another state altogether.
    for (uint64_t change = 0; change < step % 4; ++change)
      words[random_bits({9, step}, change)[0] % words.size()] += 1;
    EXPECT_EQ(sums.of(words), FieldSums().of(words)) << step;
  }
}

TEST(FieldSums, NameUpToThreeFields) {
  constexpr size_t kFields = 1700;
  const std::vector<double> before = state(kFields);
  const std::vector<uint32_t> a = sums_of(before);
  EXPECT_TRUE(differing_fields(a, a, kFields).empty());
  for (uint64_t round = 0; round < 300; ++round) {
    std::set<size_t> wanted;
    for (uint64_t draw = 0; wanted.size() < 1 + round % 3; ++draw) {
      wanted.insert(random_bits({5, round}, draw)[0] % kFields);
    }
    std::vector<double> after = before;
    for (const size_t field : wanted) after[field] += 1e-9;
    const std::vector<size_t> found = differing_fields(a, sums_of(after), kFields);
    EXPECT_EQ(std::set<size_t>(found.begin(), found.end()), wanted) << round;
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  }
}

TEST(FieldSums, AreSilentWhereMoreDiffer) {
  constexpr size_t kFields = 1700;
  const std::vector<double> before = state(kFields);
  const std::vector<uint32_t> a = sums_of(before);
  for (size_t many = 4; many < 200; ++many) {
    std::vector<double> after = before;
    for (size_t i = 0; i < many; ++i) after[(i * 37) % kFields] += 1;
    EXPECT_TRUE(differing_fields(a, sums_of(after), kFields).empty()) << many;
  }
  EXPECT_TRUE(differing_fields({}, a, kFields).empty());
  // Hostile numbers beyond the prime are no more than other numbers.
  const std::vector<uint32_t> hostile(kFieldSums, 0xFFFFFFFF);
  EXPECT_TRUE(differing_fields(hostile, a, kFields).empty());
}

}  // namespace
}  // namespace seam::scheduler
