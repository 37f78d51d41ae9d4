#include "scheduler/field_sums.h"

#include <algorithm>

#include "scheduler/field_checks.h"

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

}  // namespace

void FieldSums::field(std::string_view, double& value) {
  add(field_hash(value));
}
void FieldSums::field(std::string_view, int64_t& value) {
  add(field_hash(value));
}

void FieldSums::add(uint64_t hash) {
  const uint64_t place = ++fields_ % kPrime;
  uint64_t term = hash >> 33;
  for (uint64_t& sum : sums_) {
    sum += term;  // Has room for 2^31 of them.
    // Reduced as far as the next product needs, below 1.5 * 2^32: this runs for each field of each step.
    term *= place;
    term = (term & kPrime) + (term >> 31);
  }
}

std::vector<uint32_t> FieldSums::sums() const {
  std::vector<uint32_t> sums;
  for (const uint64_t sum : sums_) sums.push_back(static_cast<uint32_t>(sum % kPrime));
  return sums;
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
