#define SEAM_KERNEL_SET cast_kernels_base
#include "render/cast/cast_kernels.inc"
