#define SEAM_KERNEL_SET sensor_kernels_avx512
#include "effects/sensor_kernels.inc"
