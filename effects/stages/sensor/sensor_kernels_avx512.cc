#define SEAM_KERNEL_SET sensor_kernels_avx512
#include "effects/stages/sensor/sensor_kernels.inc"
