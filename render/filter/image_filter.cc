// The founding paper's CMOS filter on a finished pinhole image.
#include <algorithm>
#include <cmath>

#include "effects/questions.h"
#include "effects/stages/geometry.h"
#include "render/filter/camera_filter.h"
#include "render/filter/filter_kernels.h"
#include "render/filter/optics_filter.h"
#include "sim_core/base/error.h"

namespace seam::render {

ImageFilter::ImageFilter(const effects::Model& model, int width_px, int height_px,
                         RandomStream camera_noise)
    : filter_(model, width_px, height_px),
      sensor_(effects::sensor_of(model)),
      pattern_(effects::fixed_pattern(sensor_, width_px, height_px, 3, camera_noise)),
      kernel_(filter_.kernel().empty() ? std::vector<float>{1} : filter_.kernel()),
      gain_(filter_.gain()),
      width_px_(width_px),
      height_px_(height_px) {
  gain_.resize(whole_blocks(gain_.size()) + kFilterBlock);
  const effects::ModelEffect* pinhole = effects::base_of(model, effects::Base::projection);
  if (!pinhole)
    throw InputError(fmt::format("model '{}': found no {}, expected one", model.name(),
                                 effects::base_name(effects::Base::projection)));
  const effects::Values ideal = pinhole->values();
  const CameraRays rays = make_camera_rays(effects::Projection(model, width_px, height_px),
                                           model.name(), filter_.border_px(), 0);
  const RayTable& green = rays.table(1);
  for (size_t i = 0; i < green.base[0].size(); ++i) {
    const double u = std::clamp(ideal[0] * green.base[0][i] + ideal[2], 0.0, width_px - 1.001);
    const double v = std::clamp(ideal[1] * green.base[1][i] + ideal[3], 0.0, height_px - 1.001);
    at_.push_back(static_cast<int32_t>(v) * width_px + static_cast<int32_t>(u));
    right_.push_back(static_cast<float>(u - std::floor(u)));
    down_.push_back(static_cast<float>(v - std::floor(v)));
  }
  plan_ring(rays.columns(), rays.rows());
}

// Rows of the ideal image are taken in when the first bent row needs them, and kept until the last
// one that needs them has been made.
void ImageFilter::plan_ring(int columns, int rows) {
  std::vector<int> first(rows, height_px_);
  last_row_.assign(rows, 0);
  for (int row = 0; row < rows; ++row) {
    for (int i = row * columns; i < (row + 1) * columns; ++i) {
      first[row] = std::min(first[row], at_[i] / width_px_);
      last_row_[row] = std::max(last_row_[row], at_[i] / width_px_ + 1);
    }
    if (row > 0) last_row_[row] = std::max(last_row_[row], last_row_[row - 1]);
  }
  int oldest = height_px_;
  for (int row = rows - 1; row >= 0; --row) {
    oldest = std::min(oldest, first[row]);
    ring_rows_ = std::max(ring_rows_, last_row_[row] - oldest + 1);
  }
  for (const int32_t place : at_)
    ring_at_.push_back(4 * (place / width_px_ % ring_rows_ * width_px_ + place % width_px_));
}

// Makes the filtered image's rows of light one after the other; all it holds stays in the first
// caches.
class ImageFilter::RowMaker {
 public:
  RowMaker(const ImageFilter& filter, const LinearImage& ideal)
      : kernels_(filter_kernels()),
        filter_(filter),
        ideal_(ideal),
        taps_(static_cast<int>(filter.kernel_.size())),
        stride_(whole_blocks(filter.row_samples())),
        row_pixels_(static_cast<size_t>(filter.width_px_) * 4),
        // The ring's first row stands behind its last once more, as that one's lower neighbour.
        pixels_((filter.ring_rows_ + 1) * row_pixels_),
        bent_(stride_ + 3 * taps_ + 1),
        blurred_(taps_ * stride_),
        rows_(taps_) {
    for (int row = 0; row + 1 < taps_; ++row) bend();
  }

  // The next row, interleaved; whole blocks are written.
  void make(float* light) {
    bend();
    const int row = bent_rows_ - taps_;
    for (int k = 0; k < taps_; ++k) rows_[k] = &blurred_[(row + k) % taps_ * stride_];
    const int samples = filter_.row_samples();
    kernels_.blur_across_rows(rows_.data(), filter_.kernel_.data(), taps_,
                              &filter_.gain_[static_cast<size_t>(row) * samples], samples, light);
  }

 private:
  // The next row as the lens bends it, blurred along itself.
  void bend() {
    while (taken_rows_ <= filter_.last_row_[bent_rows_]) take_in(taken_rows_++);
    const int width = filter_.width_px_ + taps_ - 1;
    const size_t first = static_cast<size_t>(bent_rows_) * width;
    kernels_.remap(pixels_.data(), filter_.width_px_, &filter_.ring_at_[first],
                   &filter_.right_[first], &filter_.down_[first], width, bent_.data());
    kernels_.blur_along_row(bent_.data(), filter_.kernel_.data(), taps_, 3, filter_.row_samples(),
                            &blurred_[bent_rows_ % taps_ * stride_]);
    ++bent_rows_;
  }

  void take_in(int row) {
    const size_t first = static_cast<size_t>(row) * filter_.width_px_;
    const float* const planes[3] = {&ideal_.planes[0][first], &ideal_.planes[1][first],
                                    &ideal_.planes[2][first]};
    const int place = row % filter_.ring_rows_;
    kernels_.gather_colours(planes, filter_.width_px_, &pixels_[place * row_pixels_]);
    if (place == 0) {
      kernels_.gather_colours(planes, filter_.width_px_,
                              &pixels_[filter_.ring_rows_ * row_pixels_]);
    }
  }

  const FilterKernels& kernels_;
  const ImageFilter& filter_;
  const LinearImage& ideal_;
  int taps_;
  size_t stride_, row_pixels_;
  std::vector<float> pixels_, bent_, blurred_;
  std::vector<const float*> rows_;
  int taken_rows_ = 0, bent_rows_ = 0;
};

void ImageFilter::apply(const LinearImage& ideal, RandomStream frame_noise,
                        std::vector<uint8_t>& rgb) const {
  RowMaker maker(*this, ideal);
  // Light of samples [begin, end) of the frame, of which the sensor wants some at a time.
  std::vector<float> light;
  size_t begin = 0, end = 0;
  const auto more = [&](size_t first, size_t count) -> const float* {
    std::copy(light.begin() + static_cast<ptrdiff_t>(first - begin),
              light.begin() + static_cast<ptrdiff_t>(end - begin), light.begin());
    begin = first;
    light.resize(std::max(light.size(), count + row_samples() + whole_blocks(row_samples())));
    for (; end < first + count; end += row_samples()) maker.make(&light[end - begin]);
    return light.data();
  };
  rgb.resize(static_cast<size_t>(row_samples()) * height_px_);
  effects::expose_bytes(sensor_, pattern_, more, {}, frame_noise, rgb);
}

void ImageFilter::apply_in_passes(const LinearImage& ideal, RandomStream frame_noise,
                                  std::vector<uint8_t>& rgb) const {
  const int border = filter_.border_px();
  LinearImage bent{.width_px = width_px_ + 2 * border, .height_px = height_px_ + 2 * border};
  for (int c = 0; c < 3; ++c) {
    const std::vector<float>& plane = ideal.planes[c];
    bent.planes[c].resize(at_.size());
    for (size_t i = 0; i < at_.size(); ++i) {
      const float* const from = &plane[at_[i]];
      const float left = from[0] + down_[i] * (from[width_px_] - from[0]);
      const float right = from[1] + down_[i] * (from[width_px_ + 1] - from[1]);
      bent.planes[c][i] = left + right_[i] * (right - left);
    }
  }
  LinearImage light = filter_.kernel().empty() ? bent : blurred(bent, border, filter_.kernel());
  for (int c = 0; c < 3; ++c) {
    for (size_t i = 0; i < light.planes[c].size(); ++i)
      light.planes[c][i] *= filter_.gain()[3 * i + c];
  }
  // The noise as its own image, then the sum, then the rounding.
  const size_t samples = pattern_.gain.size();
  std::vector<float> noise(samples), values(samples);
  effects::sample_normals(effects::read_noise_stream(frame_noise), noise);
  for (float& value : noise) value *= static_cast<float>(sensor_.read_sigma_dn);
  for (size_t i = 0; i < samples; ++i) {
    const double signal = effects::signal_dn(sensor_, light.planes[i % 3][i / 3], {});
    values[i] = static_cast<float>(signal + sensor_.black_dn);
  }
  for (size_t i = 0; i < samples; ++i) values[i] += noise[i];
  rgb.resize(samples);
  for (size_t i = 0; i < samples; ++i)
    rgb[i] = static_cast<uint8_t>(effects::to_file(sensor_, values[i], 8));
}

}  // namespace seam::render
