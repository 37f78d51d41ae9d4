// Which fields of two states differ, found from six numbers of each state.
//
// The fields' hashes h_i, i = 1, 2, ... over all sections, are taken as a code word over the prime
// field of 2^31 - 1. S_k = sum of h_i i^k, k = 0..5, are its syndromes in the sense of Reed and
// Solomon: the differences of two states' sums show at which places the hashes differ, when these
// are at most three (Berlekamp and Massey's algorithm, see Blahut, Algebraic Codes for Data
// Transmission, 2003, chapter 7). More are not shown, and never wrongly but by a chance of less
// than 1e-10.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace seam::scheduler {

inline constexpr size_t kFieldSums = 6;

// The sums of states one after the other: what did not change since the state before is not summed
// again.
class FieldSums {
 public:
  using Sums = std::array<uint64_t, kFieldSums>;

  // Of the fields' words in order (see StateWords).
  std::vector<uint32_t> of(std::span<const int64_t> words);

 private:
  std::vector<int64_t> words_;  // Of the state before.
  std::vector<Sums> blocks_;    // Of each block of its words.
};

// The numbers, from 0, of the fields that differ between two states of so many fields, ascending.
// Nothing where the sums show none: too many differ, or the states have other numbers of fields.
std::vector<size_t> differing_fields(std::span<const uint32_t> a, std::span<const uint32_t> b,
                                     size_t fields);

}  // namespace seam::scheduler
