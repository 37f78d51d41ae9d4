#define SEAM_KERNEL_SET sensor_kernels_base
#include "effects/stages/sensor/sensor_kernels.inc"
