#include "render/gl/gather_kernels.h"

#include "sim_core/system/vector_width.h"

namespace seam::render::gl {

extern const GatherKernels gather_kernels_base;
extern const GatherKernels gather_kernels_avx2;
extern const GatherKernels gather_kernels_avx512;

const GatherKernels& gather_kernels() {
  static const GatherKernels& widest = vector_bits() >= 512   ? gather_kernels_avx512
                                       : vector_bits() >= 256 ? gather_kernels_avx2
                                                              : gather_kernels_base;
  return widest;
}

}  // namespace seam::render::gl
