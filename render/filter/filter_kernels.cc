#include "render/filter/filter_kernels.h"

#include "sim_core/system/vector_width.h"

namespace seam::render {

extern const FilterKernels filter_kernels_base;
extern const FilterKernels filter_kernels_avx2;
extern const FilterKernels filter_kernels_avx512;

const FilterKernels& filter_kernels() {
  static const FilterKernels& widest = vector_bits() >= 512   ? filter_kernels_avx512
                                       : vector_bits() >= 256 ? filter_kernels_avx2
                                                              : filter_kernels_base;
  return widest;
}

}  // namespace seam::render
