#include "sim_core/system/vector_width.h"

#include <algorithm>
#include <cstdlib>

namespace seam {
namespace {

int machine_bits() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (!__builtin_cpu_supports("avx2")) return 128;
  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                    __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
  return wide ? 512 : 256;
#else
  return 128;
#endif
}

int allowed_bits() {
  const char* limit = std::getenv("SEAM_VECTOR_BITS");
  const int bits = limit ? std::atoi(limit) : 512;
  return std::clamp(bits, 128, machine_bits());
}

}  // namespace

int vector_bits() {
  static const int bits = allowed_bits();
  return bits;
}

}  // namespace seam
