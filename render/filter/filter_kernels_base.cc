#define SEAM_KERNEL_SET filter_kernels_base
#include "render/filter/filter_kernels.inc"
