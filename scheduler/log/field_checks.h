// Two bits of each field's hash: too few to prove that fields are equal, which the fingerprint of
// the whole state does, but enough to name the one that differs once something does. Four steps in
// a row take other bits, so that a field that stays as it is shows up within them (all but 1 of
// 256).
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace seam::scheduler {

// MurmurHash3's finaliser of a field's 64 bits (see StateWords): every input bit reaches the top
// ones.
inline uint64_t field_hash(int64_t word) {
  auto bits = static_cast<uint64_t>(word);
  bits ^= bits >> 33;
  bits *= 0xff51afd7ed558ccdULL;
  bits ^= bits >> 33;
  bits *= 0xc4ceb9fe1a85ec53ULL;
  return bits;
}

// Of a state's words at a step: four fields a byte, the lowest bits first.
std::string field_checks(std::span<const int64_t> words, uint64_t step);

}  // namespace seam::scheduler
