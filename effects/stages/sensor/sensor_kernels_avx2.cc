#define SEAM_KERNEL_SET sensor_kernels_avx2
#include "effects/stages/sensor/sensor_kernels.inc"
