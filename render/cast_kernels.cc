#include "render/cast_kernels.h"

namespace seam::render {

extern const CastKernels cast_kernels_base;
extern const CastKernels cast_kernels_avx2;
extern const CastKernels cast_kernels_avx512;

int cast_kernel_sets(const CastKernels* sets[3]) {
  int count = 0;
  sets[count++] = &cast_kernels_base;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) sets[count++] = &cast_kernels_avx2;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
    sets[count++] = &cast_kernels_avx512;
  }
#endif
  return count;
}

const CastKernels& cast_kernels() {
  static const CastKernels& widest = [] () -> const CastKernels& {
    const CastKernels* sets[3];
    return *sets[cast_kernel_sets(sets) - 1];
  }();
  return widest;
}

}  // namespace seam::render
