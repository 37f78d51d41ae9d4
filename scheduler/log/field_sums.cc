#include "scheduler/log/field_sums.h"

#include <algorithm>
#include <array>

#include "scheduler/log/field_checks.h"

namespace seam::scheduler {
namespace {

constexpr uint64_t kPrime = (uint64_t{1} << 31) - 1;

// Of a number below 2^62.
uint64_t reduced(uint64_t value) {
  value = (value & kPrime) + (value >> 31);
  return value >= kPrime ? value - kPrime : value;
}

uint64_t product(uint64_t a, uint64_t b) {
  return reduced(a * b);
}
uint64_t difference(uint64_t a, uint64_t b) {
  return a >= b ? a - b : a + kPrime - b;
}

// By Fermat's little theorem.
uint64_t inverse(uint64_t value) {
  uint64_t result = 1;
  for (uint64_t power = kPrime - 2; power > 0; power >>= 1) {
    if (power & 1) result = product(result, value);
    value = product(value, value);
  }
  return result;
}

using Polynomial = std::vector<uint64_t>;  // Coefficients, the constant first.

// The shortest C with C_0 = 1 and sum of C_j S_(k-j) = 0 for all k >= its degree (Massey 1969).
Polynomial connection_polynomial(std::span<const uint64_t> S) {
  Polynomial C = {1}, B = {1};
  uint64_t b = 1;  // The discrepancy at which B was kept.
  size_t L = 0, shift = 1;
  for (size_t k = 0; k < S.size(); ++k, ++shift) {
    uint64_t d = 0;
    for (size_t j = 0; j <= L && j < C.size(); ++j) d = reduced(d + product(C[j], S[k - j]));
    if (d == 0) continue;
    const Polynomial before = C;
    const uint64_t factor = product(d, inverse(b));
    C.resize(std::max(C.size(), B.size() + shift), 0);
    for (size_t j = 0; j < B.size(); ++j) {
      C[j + shift] = difference(C[j + shift], product(factor, B[j]));
    }
    if (2 * L > k) continue;
    L = k + 1 - L;
    B = before;
    b = d;
    shift = 0;
  }
  C.resize(L + 1, 0);
  return C;
}

// The sums of the fields of one block, whose first has the number `first`. With places i = first +
// j,
//   sum of h i^k = sum over m of C(k, m) first^(k - m) * (sum of h j^m),
// and powers of j are too small to need a reduction: 2^31 * (sum of j^5, j < 32) < 2^59.
constexpr size_t kBlock = 32;

FieldSums::Sums sums_of_block(std::span<const int64_t> words, uint64_t first) {
  constexpr uint64_t kBinomials[kFieldSums][kFieldSums] = {
      {1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}, {1, 4, 6, 4, 1}, {1, 5, 10, 10, 5, 1}};
  uint64_t m0 = 0, m1 = 0, m2 = 0, m3 = 0, m4 = 0,
           m5 = 0;  // Not an array: they shall stay in registers.
  for (size_t j = 0; j < words.size(); ++j) {
    const uint64_t h = field_hash(words[j]) >> 33;
    const uint64_t h1 = h * j, h2 = h1 * j, h3 = h2 * j, h4 = h3 * j, h5 = h4 * j;
    m0 += h, m1 += h1, m2 += h2, m3 += h3, m4 += h4, m5 += h5;
  }
  const std::array<uint64_t, kFieldSums> moments{m0, m1, m2, m3, m4, m5};
  std::array<uint64_t, kFieldSums> powers{1};
  for (size_t k = 1; k < kFieldSums; ++k) powers[k] = product(powers[k - 1], first % kPrime);
  FieldSums::Sums sums{};
  for (size_t m = 0; m < kFieldSums; ++m) {
    const uint64_t moment = moments[m] % kPrime;
    for (size_t k = m; k < kFieldSums; ++k)
      sums[k] = reduced(sums[k] + kBinomials[k][m] * product(powers[k - m], moment));
  }
  return sums;
}

}  // namespace

std::vector<uint32_t> FieldSums::of(std::span<const int64_t> words) {
  if (words.size() != words_.size()) {
    words_.assign(words.size(), 0);
    blocks_.clear();
  }
  Sums sums{};
  for (size_t first = 0; first < words.size(); first += kBlock) {
    const auto block = words.subspan(first, std::min(kBlock, words.size() - first));
    const bool known = first / kBlock < blocks_.size();
    if (!known) blocks_.emplace_back();
    Sums& part = blocks_[first / kBlock];
    if (!known ||
        !std::equal(block.begin(), block.end(), words_.begin() + static_cast<ptrdiff_t>(first))) {
      std::copy(block.begin(), block.end(), words_.begin() + static_cast<ptrdiff_t>(first));
      part = sums_of_block(block, first + 1);
    }
    for (size_t k = 0; k < kFieldSums; ++k) sums[k] = reduced(sums[k] + part[k]);
  }
  return {sums.begin(), sums.end()};
}

std::vector<size_t> differing_fields(std::span<const uint32_t> a, std::span<const uint32_t> b,
                                     size_t fields) {
  if (a.size() != kFieldSums || b.size() != kFieldSums) return {};
  std::array<uint64_t, kFieldSums> S{};
  for (size_t k = 0; k < kFieldSums; ++k) S[k] = difference(a[k] % kPrime, b[k] % kPrime);
  const Polynomial C = connection_polynomial(S);
  const size_t count = C.size() - 1;
  if (count == 0 || 2 * count > kFieldSums) return {};
  // The places are the roots of C reversed: all numbers are tried, as they are few.
  std::vector<size_t> found;
  for (size_t field = 0; field < fields && found.size() < count; ++field) {
    uint64_t value = 0;
    for (const uint64_t coefficient : C)
      value = reduced(product(value, (field + 1) % kPrime) + coefficient);
    if (value == 0) found.push_back(field);
  }
  if (found.size() != count) return {};
  return found;
}

}  // namespace seam::scheduler
