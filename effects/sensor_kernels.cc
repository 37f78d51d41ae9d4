#include "effects/sensor_kernels.h"

namespace seam::effects {

extern const SensorKernels sensor_kernels_base;
extern const SensorKernels sensor_kernels_avx2;
extern const SensorKernels sensor_kernels_avx512;

int sensor_kernel_sets(const SensorKernels* sets[3]) {
  int count = 0;
  sets[count++] = &sensor_kernels_base;
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) sets[count++] = &sensor_kernels_avx2;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw")) {
    sets[count++] = &sensor_kernels_avx512;
  }
#endif
  return count;
}

const SensorKernels& sensor_kernels() {
  static const SensorKernels& widest = [] () -> const SensorKernels& {
    const SensorKernels* sets[3];
    return *sets[sensor_kernel_sets(sets) - 1];
  }();
  return widest;
}

}  // namespace seam::effects
