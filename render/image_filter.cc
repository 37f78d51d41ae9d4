// The founding paper's CMOS filter on a finished pinhole image.
#include <algorithm>
#include <cmath>

#include "effects/geometry.h"
#include "render/camera_filter.h"
#include "render/filter_kernels.h"
#include "render/optics_filter.h"
#include "sim_core/error.h"

namespace seam::render {

ImageFilter::ImageFilter(const effects::Model& model, int width_px, int height_px,
                         RandomStream camera_noise)
    : filter_(effects::optics_of(model),
              effects::GainField(model, effects::Stage::radiometry, width_px, height_px), width_px,
              height_px),
      sensor_(effects::sensor_of(model)),
      pattern_(effects::fixed_pattern(sensor_, width_px, height_px, 3, camera_noise)),
      kernel_(filter_.kernel().empty() ? std::vector<float>{1} : filter_.kernel()),
      width_px_(width_px),
      height_px_(height_px) {
  const effects::ModelEffect* pinhole = model.find("pinhole");
  if (!pinhole)
    throw InputError(fmt::format("model '{}': found no pinhole, expected one", model.name()));
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
}

void ImageFilter::apply(const LinearImage& ideal, RandomStream frame_noise, Scratch& scratch,
                        std::vector<uint8_t>& rgb) const {
  const FilterKernels& kernels = filter_kernels();
  const int taps = static_cast<int>(kernel_.size());
  const int samples = 3 * width_px_, bent_width = width_px_ + taps - 1;
  // One bent row, what the row blur reads beyond it, and the rows that one row's blur needs.
  const size_t stride = whole_blocks(samples);
  scratch.pixels.resize(4 * static_cast<size_t>(width_px_) * height_px_);
  scratch.bent.resize(stride + 3 * taps + 1);
  scratch.ring.resize(taps * stride);
  scratch.rows.resize(taps);
  scratch.illumination.resize(static_cast<size_t>(samples) * (height_px_ - 1) + stride);
  const float* const planes[3] = {ideal.planes[0].data(), ideal.planes[1].data(),
                                  ideal.planes[2].data()};
  kernels.gather_colours(planes, width_px_ * height_px_, scratch.pixels.data());
  for (int below = 0; below < height_px_ + taps - 1; ++below) {
    const size_t first = static_cast<size_t>(below) * bent_width;
    kernels.remap(scratch.pixels.data(), width_px_, &at_[first], &right_[first], &down_[first],
                  bent_width, scratch.bent.data());
    kernels.blur_along_row(scratch.bent.data(), kernel_.data(), taps, 3, samples,
                           &scratch.ring[below % taps * stride]);
    const int row = below - taps + 1;
    if (row < 0) continue;
    for (int k = 0; k < taps; ++k) scratch.rows[k] = &scratch.ring[(row + k) % taps * stride];
    float* const light = &scratch.illumination[static_cast<size_t>(row) * samples];
    kernels.blur_across_rows(scratch.rows.data(), kernel_.data(), taps, samples, light);
    kernels.multiply(&filter_.gain()[static_cast<size_t>(row) * samples], 1, samples, light);
  }
  rgb.resize(static_cast<size_t>(samples) * height_px_);
  effects::expose_bytes(sensor_, pattern_, std::span(scratch.illumination).first(rgb.size()), {},
                        frame_noise, rgb);
}

void ImageFilter::apply_in_passes(const LinearImage& ideal, RandomStream frame_noise,
                                  std::vector<uint8_t>& rgb) const {
  const int border = filter_.border_px();
  LinearImage bent{.width_px = width_px_ + 2 * border, .height_px = height_px_ + 2 * border};
  for (int c = 0; c < 3; ++c) {
    const std::vector<float>& plane = ideal.planes[c];
    bent.planes[c].resize(at_.size());
    for (size_t i = 0; i < at_.size(); ++i) {
      const float top = plane[at_[i]] + right_[i] * (plane[at_[i] + 1] - plane[at_[i]]);
      const float bottom = plane[at_[i] + width_px_] +
                           right_[i] * (plane[at_[i] + width_px_ + 1] - plane[at_[i] + width_px_]);
      bent.planes[c][i] = top + down_[i] * (bottom - top);
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
  effects::sample_normals(frame_noise.child("read_noise"), noise);
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
