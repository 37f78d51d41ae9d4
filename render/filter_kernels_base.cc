#define SEAM_KERNEL_SET filter_kernels_base
#include "render/filter_kernels.inc"
