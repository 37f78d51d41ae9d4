#define SEAM_KERNEL_SET cast_kernels_avx2
#include "render/cast/cast_kernels.inc"
