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

void ImageFilter::apply(const LinearImage& ideal, RandomStream frame_noise,
                        std::vector<uint8_t>& rgb) const {
  const FilterKernels& kernels = filter_kernels();
  const int border = filter_.border_px();
  LinearImage bent{.width_px = width_px_ + 2 * border, .height_px = height_px_ + 2 * border};
  for (int c = 0; c < 3; ++c) {
    bent.planes[c].resize(at_.size());
    kernels.remap(ideal.planes[c].data(), width_px_, at_.data(), right_.data(), down_.data(),
                  static_cast<int>(at_.size()), bent.planes[c].data());
  }
  std::vector<float> illumination;
  const std::vector<float> steady(height_px_, 1.0f);
  filter_.apply(bent, {}, steady, illumination);
  const Image image = effects::expose(sensor_, pattern_, illumination, {}, frame_noise);
  rgb.assign(image.samples.begin(), image.samples.end());
}

void ImageFilter::apply_in_passes(const LinearImage& ideal, RandomStream frame_noise,
                                  std::vector<uint8_t>& rgb) const {
  const int border = filter_.border_px();
  LinearImage bent{.width_px = width_px_ + 2 * border, .height_px = height_px_ + 2 * border};
  for (int c = 0; c < 3; ++c) {
    const std::vector<float>& plane = ideal.planes[c];
    for (size_t i = 0; i < at_.size(); ++i) {
      const float top = plane[at_[i]] + right_[i] * (plane[at_[i] + 1] - plane[at_[i]]);
      const float bottom = plane[at_[i] + width_px_] +
                           right_[i] * (plane[at_[i] + width_px_ + 1] - plane[at_[i] + width_px_]);
      bent.planes[c].push_back(top + down_[i] * (bottom - top));
    }
  }
  LinearImage light = filter_.kernel().empty() ? bent : blurred(bent, border, filter_.kernel());
  std::array<std::vector<float>, 3> gain;
  for (size_t i = 0; i < filter_.gain().size(); ++i) gain[i % 3].push_back(filter_.gain()[i]);
  apply_gain(light, gain);
  // The noise as its own image, then the sum, then the rounding.
  const size_t samples = pattern_.gain.size();
  std::vector<double> noise(samples), values(samples);
  const RandomStream read = frame_noise.child("read_noise");
  for (size_t i = 0; i < samples; ++i)
    noise[i] = sensor_.read_sigma_dn * effects::sample_normal(read, i);
  for (size_t i = 0; i < samples; ++i)
    values[i] =
        effects::signal_dn(sensor_, light.planes[i % 3][i / 3], {}) + sensor_.black_dn + noise[i];
  rgb.resize(samples);
  for (size_t i = 0; i < samples; ++i)
    rgb[i] = static_cast<uint8_t>(effects::to_file(sensor_, values[i], 8));
}

}  // namespace seam::render
