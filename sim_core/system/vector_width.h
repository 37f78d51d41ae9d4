// How wide this machine's vectors are, for loops that are compiled for several widths
// (seam_vector_kernels in cmake/SeamModule.cmake). The width never changes a bit of any result.
#pragma once

namespace seam {

// 128, 256 (AVX2) or 512 (AVX-512 F, VL, DQ, BW). The environment variable SEAM_VECTOR_BITS lowers
// it, for tests of equal bits.
int vector_bits();

}  // namespace seam
