// For the vector kernels (*.inc): a loop whose steps write nothing that another one reads.
#pragma once

#if defined(__clang__)
#define SEAM_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define SEAM_INDEPENDENT _Pragma("GCC ivdep")
#endif
