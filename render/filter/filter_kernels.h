// The inner loops of the lens's filter, compiled for several vector widths (see cast_kernels.h for
// the rules that keep their bits equal).
#pragma once

#include <cstddef>
#include <cstdint>

namespace seam::render {

// Loops that sum taps work on whole blocks of so many floats: they read and write up to the next
// multiple of it, and buffers are that much longer.
inline constexpr int kFilterBlock = 64;
constexpr size_t whole_blocks(size_t count) {
  return (count + kFilterBlock - 1) / kFilterBlock * kFilterBlock;
}

// Sums over the rows around one: of the kernel's weight g, and of g times powers of the row's
// distance in time, which carry the point spread of a moving camera (camera_filter.h).
struct RowMoments {
  float* s0;
  float* s1;
  float* s2;
  float* s4;
};

// Directions of a row's pixels, with z, and the derivatives of their x and y along u and v.
struct RowDirections {
  const float* x;
  const float* y;
  const float* z;
  const float* x_along_u;
  const float* x_along_v;
  const float* y_along_u;
  const float* y_along_v;
};

// How a row moves while the rows are exposed (RowMotion of camera_filter.h).
struct RowTurning {
  double omega_C[3];  // The camera's turning, rad/s.
  double line_delay_s;
  double sigma_px;    // The lens's point spread.
  double fastest_px;  // Columns or rows a row: faster motion is clipped.
  double still_px;    // Slower motion is none.
};

struct FilterKernels {
  // out[i] = sum of kernel[k] * in[i + k * step], k ascending from 0 to taps - 1. Whole blocks.
  void (*blur_along_row)(const float* in, const float* kernel, int taps, int step, int count,
                         float* out);
  // out[i] = sum of kernel[k] * rows[k][i], k ascending, times gain[i] where there is one. Whole
  // blocks.
  void (*blur_across_rows)(const float* const* rows, const float* kernel, int taps,
                           const float* gain, int count, float* out);
  // The four sums at once; row k is distances[k] rows away. Whole blocks.
  void (*moments_across_rows)(const float* const* rows, const float* kernel, const float* distances,
                              int taps, int count, RowMoments sums);
  // The row's blurred light from its sums, which begin one column before the first:
  // s0 + shear * d(s1)/du + shear^2/2 * d2(s2)/du2 + stretch * (s2 / sigma^4 - s0 / sigma^2)
  //    + stretch^2/2 * (s4 / sigma^8 - 6 s2 / sigma^6 + 3 s0 / sigma^4).
  void (*moving_blur)(RowMoments sums, const float* shear, const float* stretch, float sigma,
                      int count, float* out);
  // out[3 i + c] = planes[c][i] * gain[3 i + c] * factor.
  void (*interleave)(const float* const* planes, const float* gain, float factor, int count,
                     float* out);
  // out[4 i + c] = planes[c][i], out[4 i + 3] = 0.
  void (*gather_colours)(const float* const* planes, int count, float* out);
  // Bilinear samples of pixels of four floats: the pixel from float at[i] on and its right, lower
  // and lower right neighbours give out[3 i] to out[3 i + 2]; out[3 count] is written too. `stride`
  // is in pixels.
  void (*remap)(const float* in, int stride, const int32_t* at, const float* right,
                const float* down, int count, float* out);
  // Shear and stretch of each pixel; returns how many of them move.
  int (*row_motion)(const RowDirections& row, const RowTurning& turning, int count, float* shear,
                    float* stretch);
  // value[3 i + c] = kept * value[3 i + c] + everywhere[c].
  void (*glare)(float kept, const float* everywhere, size_t pixels, float* value);
  const char* name;
};

const FilterKernels& filter_kernels();
}  // namespace seam::render
