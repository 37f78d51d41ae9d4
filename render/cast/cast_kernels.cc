#include "render/cast/cast_kernels.h"

#include "sim_core/system/vector_width.h"

namespace seam::render {

extern const CastKernels cast_kernels_base;
extern const CastKernels cast_kernels_avx2;
extern const CastKernels cast_kernels_avx512;

const CastKernels& cast_kernels() {
  static const CastKernels& widest = vector_bits() >= 512   ? cast_kernels_avx512
                                     : vector_bits() >= 256 ? cast_kernels_avx2
                                                            : cast_kernels_base;
  return widest;
}

}  // namespace seam::render
