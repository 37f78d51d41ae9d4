#define SEAM_KERNEL_SET gather_kernels_avx512
#include "render/gl/gather_kernels.inc"
