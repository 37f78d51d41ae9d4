#define SEAM_KERNEL_SET cast_kernels_avx512
#include "render/cast/cast_kernels.inc"
