// The fused filter: blur, lamps, gain field, glare and own light in one pass over the image with
// precomputed tables, giving the illumination that effects::expose turns into digital numbers.
// Distortion is in the rays; `ImageFilter` does it too, for images that were not made by this
// renderer.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "effects/stages/optics.h"
#include "effects/stages/sensor/sensor.h"
#include "render/base/linear_image.h"
#include "render/cast/ray_table.h"
#include "sim_core/scene/frame.h"

namespace seam::render {

// How the image moves while the rows are exposed one after the other: for each pixel, the columns
// (`shear`) by which what it shows has moved when the next row is exposed, and the growth of the
// point spread's variance along columns in the assembled image over two, px^2 (`stretch`).
//
// A lens blurs each instant's image; rows are assembled later. Blurring the assembled image with
// the lens's own kernel is therefore wrong while the camera turns: a row's neighbours were exposed
// at other times. The kernel that is right in the assembled image is the lens's, sheared and
// stretched by the motion between rows. With shear k and downwards motion b (pixels a row) it is
//   (1 - b) g((1 - b) dv) g(du - k dv).
struct RowMotion {
  bool still = true;
  std::vector<float> shear;
  std::vector<float> stretch;
};

// From the turning of the camera (its translation and the objects' own motion are left out: they
// change the kernel by a small part of what the turning does).
RowMotion row_motion(const FrameJob& job, const CameraRays& rays, double sigma_px);

class CameraFilter {
 public:
  CameraFilter(const effects::Model& model, int width_px, int height_px);

  int border_px() const { return static_cast<int>(kernel_.size() / 2); }
  const std::vector<float>& kernel() const { return kernel_; }
  // Gain of each sample, interleaved.
  const std::vector<float>& gain() const { return gain_; }
  // Light of the camera itself on each sample, interleaved; empty where there is none.
  const std::vector<float>& own_light() const { return own_light_; }

  // `image` has this filter's border. `lamps`: a factor for each row. Result: interleaved,
  // row-major.
  void apply(const LinearImage& image, const RowMotion& motion, std::span<const float> lamps,
             std::vector<float>& illumination) const;
  // The blur alone.
  LinearImage blurred(const LinearImage& image, const RowMotion& motion) const;

 private:
  void add_glare(std::vector<float>& illumination) const;
  // Calls take(row, light) for each row of the blurred image, with the row of each colour.
  template <typename Take>
  void blur(const LinearImage& image, const RowMotion& motion, const Take& take) const;

  effects::Optics optics_;
  int width_px_, height_px_;
  std::vector<float> kernel_;
  std::vector<float> gain_;
  std::vector<float> own_light_;
};

// Distortion, blur, gain field, noise and quantisation of an ideal pinhole image in one pass: the
// founding paper's CMOS filter. The ideal image has the model's pinhole, this width and height, and
// is continued by its outermost pixels.
class ImageFilter {
 public:
  ImageFilter(const effects::Model& model, int width_px, int height_px, RandomStream camera_noise);
  // Interleaved RGB, 8 bits.
  void apply(const LinearImage& ideal, RandomStream frame_noise, std::vector<uint8_t>& rgb) const;
  // The same in separate passes over the image, with plain loops.
  void apply_in_passes(const LinearImage& ideal, RandomStream frame_noise,
                       std::vector<uint8_t>& rgb) const;

 private:
  class RowMaker;
  void plan_ring(int columns, int rows);
  int row_samples() const { return 3 * width_px_; }

  CameraFilter filter_;
  effects::SensorChain sensor_;
  effects::FixedPattern pattern_;
  std::vector<float> kernel_;  // The filter's, or a single 1.
  std::vector<float> gain_;    // The filter's, and some more for whole blocks.
  int width_px_, height_px_;
  // Of the bordered image: the upper left of four neighbours, and how far towards the others.
  std::vector<int32_t> at_;
  std::vector<float> right_, down_;
  // The last row of the ideal image that the bent rows up to each need; how many rows are in use at
  // once; and where `at_` finds its pixel among these.
  std::vector<int> last_row_;
  int ring_rows_ = 1;
  std::vector<int32_t> ring_at_;
};

}  // namespace seam::render
