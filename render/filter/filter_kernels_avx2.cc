#define SEAM_KERNEL_SET filter_kernels_avx2
#include "render/filter/filter_kernels.inc"
