#include "render/filter/optics_filter.h"

#include "sim_core/base/error.h"

namespace seam::render {

LinearImage without_border(const LinearImage& image, int border_px) {
  LinearImage inner{.width_px = image.width_px - 2 * border_px,
                    .height_px = image.height_px - 2 * border_px};
  for (int c = 0; c < 3; ++c) {
    inner.planes[c].reserve(static_cast<size_t>(inner.width_px) * inner.height_px);
    for (int v = 0; v < inner.height_px; ++v) {
      const auto row = image.planes[c].begin() +
                       static_cast<ptrdiff_t>(v + border_px) * image.width_px + border_px;
      inner.planes[c].insert(inner.planes[c].end(), row, row + inner.width_px);
    }
  }
  return inner;
}

LinearImage blurred(const LinearImage& image, int border_px, const std::vector<float>& kernel) {
  const int radius = static_cast<int>(kernel.size() / 2);
  SEAM_CHECK(radius <= border_px, "radius {} border {}", radius, border_px);
  LinearImage result{.width_px = image.width_px - 2 * border_px,
                     .height_px = image.height_px - 2 * border_px};
  std::vector<float> along_rows(static_cast<size_t>(result.width_px) * image.height_px);
  for (int c = 0; c < 3; ++c) {
    for (int v = 0; v < image.height_px; ++v) {
      for (int u = 0; u < result.width_px; ++u) {
        const float* from =
            &image.planes[c][static_cast<size_t>(v) * image.width_px + u + border_px - radius];
        float sum = 0;
        for (size_t k = 0; k < kernel.size(); ++k) sum += kernel[k] * from[k];
        along_rows[static_cast<size_t>(v) * result.width_px + u] = sum;
      }
    }
    result.planes[c].resize(static_cast<size_t>(result.width_px) * result.height_px);
    for (int v = 0; v < result.height_px; ++v) {
      for (int u = 0; u < result.width_px; ++u) {
        float sum = 0;
        for (size_t k = 0; k < kernel.size(); ++k) {
          sum += kernel[k] * along_rows[(v + border_px - radius + k) * result.width_px + u];
        }
        result.planes[c][static_cast<size_t>(v) * result.width_px + u] = sum;
      }
    }
  }
  return result;
}

void scale_rows(LinearImage& image, const std::vector<float>& factors) {
  for (auto& plane : image.planes) {
    for (size_t i = 0; i < plane.size(); ++i) plane[i] *= factors[i / image.width_px];
  }
}

void apply_gain(LinearImage& image, const std::array<std::vector<float>, 3>& gain) {
  for (int c = 0; c < 3; ++c) {
    for (size_t i = 0; i < image.planes[c].size(); ++i) image.planes[c][i] *= gain[c][i];
  }
}

void add_glare(LinearImage& image, double fraction) {
  for (auto& plane : image.planes) {
    double sum = 0;
    for (const float light : plane) sum += light;
    const auto everywhere = static_cast<float>(fraction * sum / static_cast<double>(plane.size()));
    const auto kept = static_cast<float>(1 - fraction);
    for (float& light : plane) light = kept * light + everywhere;
  }
}

void add_own_light(LinearImage& image, const std::vector<float>& light) {
  for (size_t i = 0; i < light.size(); ++i) image.planes[i % 3][i / 3] += light[i];
}

}  // namespace seam::render
