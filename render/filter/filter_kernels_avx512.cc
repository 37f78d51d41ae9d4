#define SEAM_KERNEL_SET filter_kernels_avx512
#include "render/filter/filter_kernels.inc"
