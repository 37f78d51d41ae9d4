#define SEAM_KERNEL_SET gather_kernels_base
#include "render/gl/gather_kernels.inc"
