#include "effects/stages/sensor/sensor_kernels.h"

#include "sim_core/system/vector_width.h"

namespace seam::effects {

extern const SensorKernels sensor_kernels_base;
extern const SensorKernels sensor_kernels_avx2;
extern const SensorKernels sensor_kernels_avx512;

const SensorKernels& sensor_kernels() {
  static const SensorKernels& widest = vector_bits() >= 512   ? sensor_kernels_avx512
                                       : vector_bits() >= 256 ? sensor_kernels_avx2
                                                              : sensor_kernels_base;
  return widest;
}

}  // namespace seam::effects
