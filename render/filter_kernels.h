// The inner loops of the lens's filter, compiled for several vector widths (see cast_kernels.h for
// the rules that keep their bits equal).
#pragma once

#include <cstdint>

namespace seam::render {

// Sums over the rows around one: of the kernel's weight g, and of g times powers of the row's
// distance in time, which carry the point spread of a moving camera (camera_filter.h).
struct RowMoments {
  float* s0;
  float* s1;
  float* s2;
  float* s4;
};

struct FilterKernels {
  // out[i] = sum of kernel[k] * in[i + k], k from 0 to taps - 1.
  void (*blur_along_row)(const float* in, const float* kernel, int taps, int count, float* out);
  // sum[i] += weight * row[i].
  void (*add_row)(const float* row, float weight, int count, float* sum);
  // The four sums at once, `distance` in rows.
  void (*add_moments)(const float* row, float weight, float distance, int count, RowMoments sums);
  // The row's blurred light from its sums, which begin one column before the first:
  // s0 + shear * d(s1)/du + shear^2/2 * d2(s2)/du2 + stretch * (s2 / sigma^4 - s0 / sigma^2)
  //    + stretch^2/2 * (s4 / sigma^8 - 6 s2 / sigma^6 + 3 s0 / sigma^4).
  void (*moving_blur)(RowMoments sums, const float* shear, const float* stretch, float sigma,
                      int count, float* out);
  // out[3 i + channel] = in[i] * gain[3 i + channel] * factor.
  void (*interleave)(const float* in, const float* gain, float factor, int channel, int count,
                     float* out);
  // Bilinear samples: in[at[i]] and its right, lower and lower right neighbours.
  void (*remap)(const float* in, int stride, const int32_t* at, const float* right,
                const float* down, int count, float* out);
  const char* name;
};

const FilterKernels& filter_kernels();
}  // namespace seam::render
