#include "render/filter_kernels.h"

namespace seam::render {

extern const FilterKernels filter_kernels_base;
extern const FilterKernels filter_kernels_avx2;
extern const FilterKernels filter_kernels_avx512;

int filter_kernel_sets(const FilterKernels* sets[3]) {
  int count = 0;
  sets[count++] = &filter_kernels_base;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) sets[count++] = &filter_kernels_avx2;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
    sets[count++] = &filter_kernels_avx512;
  }
#endif
  return count;
}

const FilterKernels& filter_kernels() {
  static const FilterKernels& widest = [] () -> const FilterKernels& {
    const FilterKernels* sets[3];
    return *sets[filter_kernel_sets(sets) - 1];
  }();
  return widest;
}

}  // namespace seam::render
