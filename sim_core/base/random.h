// Counter-based random numbers: a pure function of (seed, stream, index), so that noise does not
// depend on the order in which it is drawn, on threads, or on what else draws. Philox4x32-10
// (Salmon et al., SC 2011) through Random123.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace seam {

// Names one independent sequence of random numbers.
struct RandomStream {
  uint64_t seed = 0;
  uint64_t stream = 0;

  // A sub-stream named by text or number; different names give independent streams.
  RandomStream child(std::string_view name) const;
  RandomStream child(uint64_t number) const;
};

// 128 random bits of the stream at this index.
std::array<uint32_t, 4> random_bits(RandomStream stream, uint64_t index);

// Uniform in (0, 1), 53 bits, never 0 or 1.
double uniform(RandomStream stream, uint64_t index);

// Standard normal (Box-Muller with machine-independent maths).
double normal(RandomStream stream, uint64_t index);

// Poisson with this mean >= 0: inversion below 30, transformed rejection (Hormann, PTRS) above;
// a draw at index uses only random numbers derived from index.
uint64_t poisson(RandomStream stream, uint64_t index, double mean);

}  // namespace seam
