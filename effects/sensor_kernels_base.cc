#define SEAM_KERNEL_SET sensor_kernels_base
#include "effects/sensor_kernels.inc"
