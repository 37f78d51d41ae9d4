#include "render/filter/camera_filter.h"

#include <algorithm>
#include <cmath>

#include "render/filter/filter_kernels.h"
#include "render/filter/optics_filter.h"
#include "render/filter/point_spread.h"
#include "sim_core/base/error.h"

namespace seam::render {
namespace {

// Below this many pixels a row the motion changes no digit of a frame.
constexpr double kStillPx = 1e-3;
// Faster turning than this (pixels a row) is clipped: the expansion holds no further.
constexpr double kFastestPx = 0.6;

// The camera's turning in its own frame, rad/s, about the time of a row: the antisymmetric part of
// the change of its rotation.
Vec3 turning(const FrameJob& job, SimTime time) {
  const auto after = std::lower_bound(job.instants.begin(), job.instants.end(), time,
                                      [](const SceneInstant& a, SimTime t) { return a.time < t; });
  const auto b = std::clamp(after, job.instants.begin() + 1, job.instants.end() - 1);
  const auto a = b - 1;
  const Mat3 change = glm::transpose(a->X_WC.R) * b->X_WC.R;
  const double span_s = (b->time - a->time).s();
  return Vec3(change[1][2] - change[2][1], change[2][0] - change[0][2],
              change[0][1] - change[1][0]) *
         (0.5 / span_s);
}

}  // namespace

RowMotion row_motion(const FrameJob& job, const CameraRays& rays, double sigma_px) {
  RowMotion motion;
  if (sigma_px < kLeastSampledSigma_px || job.instants.size() < 2 || rays.height_px < 2)
    return motion;
  const auto middle = [](const RowWindow& row) { return row.start + (row.end - row.start) / 2; };
  const std::vector<RowWindow>& rows = job.schedule.rows;
  const double line_delay_s = (rows.back().start - rows.front().start).s() / (rays.height_px - 1);
  if (line_delay_s == 0) return motion;
  const size_t pixels = static_cast<size_t>(rays.width_px) * rays.height_px;
  motion.shear.resize(pixels), motion.stretch.resize(pixels);
  const RayTable& green = rays.table(1);
  const FilterKernels& kernels = filter_kernels();
  for (int v = 0; v < rays.height_px; ++v) {
    const Vec3 omega_C = turning(job, middle(rows[v]));
    const size_t i = rays.at(v + rays.border_px) + rays.border_px;
    const RowDirections directions{&green.base[0][i],    &green.base[1][i],    &green.base[2][i],
                                   &green.along_u[0][i], &green.along_v[0][i], &green.along_u[1][i],
                                   &green.along_v[1][i]};
    const RowTurning row{.omega_C = {omega_C.x, omega_C.y, omega_C.z},
                         .line_delay_s = line_delay_s,
                         .sigma_px = sigma_px,
                         .fastest_px = kFastestPx,
                         .still_px = kStillPx};
    const size_t pixel = static_cast<size_t>(v) * rays.width_px;
    if (kernels.row_motion(directions, row, rays.width_px, &motion.shear[pixel],
                           &motion.stretch[pixel]) > 0) {
      motion.still = false;
    }
  }
  return motion;
}

CameraFilter::CameraFilter(const effects::Model& model, int width_px, int height_px)
    : optics_(effects::optics_of(model)),
      width_px_(width_px),
      height_px_(height_px),
      kernel_(point_spread(optics_)) {
  const effects::GainField gain(model, effects::Stage::radiometry, width_px, height_px);
  const effects::OwnLight own(model, width_px, height_px);
  gain_.reserve(static_cast<size_t>(width_px) * height_px * 3);
  for (int v = 0; v < height_px; ++v) {
    for (int u = 0; u < width_px; ++u) {
      for (int c = 0; c < 3; ++c) {
        gain_.push_back(static_cast<float>(gain.at(u, v, 0, c)));
        if (!std::isfinite(gain_.back())) gain.check_at(u, v, 0, c);
      }
      if (!own.none()) own_light_.insert(own_light_.end(), 3, static_cast<float>(own.at(u, v)));
    }
  }
}

template <typename Take>
void CameraFilter::blur(const LinearImage& image, const RowMotion& motion, const Take& take) const {
  const FilterKernels& kernels = filter_kernels();
  const int radius = border_px(), taps = static_cast<int>(kernel_.size());
  SEAM_CHECK(image.width_px == width_px_ + 2 * radius && image.height_px == height_px_ + 2 * radius,
             "{} {}", image.width_px, image.height_px);
  if (radius == 0) {
    for (int v = 0; v < height_px_; ++v) {
      const size_t first = static_cast<size_t>(v) * width_px_;
      const float* const rows[3] = {&image.planes[0][first], &image.planes[1][first],
                                    &image.planes[2][first]};
      take(v, rows);
    }
    return;
  }
  // One column more on each side for the slopes of `moving_blur`, whose kernel there is cut off.
  const int wide = width_px_ + 2;
  const size_t stride = whole_blocks(wide);
  // Of each colour the rows that one row's blur needs, blurred along the row: a ring.
  std::vector<float> ring(3 * taps * stride), padded(stride + taps), sums(4 * stride);
  std::vector<float> light(3 * stride), distances(taps);
  std::vector<const float*> rows(taps);
  const RowMoments moments{&sums[0], &sums[stride], &sums[2 * stride], &sums[3 * stride]};
  const auto ring_row = [&](int c, int v) { return &ring[(c * taps + v % taps) * stride]; };
  const float* lights[3];
  for (int c = 0; c < 3; ++c) lights[c] = &light[c * stride] + (motion.still ? 1 : 0);
  for (int below = 0; below < image.height_px; ++below) {
    for (int c = 0; c < 3; ++c) {
      const float* row = &image.planes[c][static_cast<size_t>(below) * image.width_px];
      std::copy_n(row, image.width_px, padded.begin() + 1);
      padded[0] = row[0], padded[image.width_px + 1] = row[image.width_px - 1];
      kernels.blur_along_row(padded.data(), kernel_.data(), taps, 1, wide, ring_row(c, below));
    }
    const int v = below - taps + 1;
    if (v < 0) continue;
    // Rows beyond the image are exposed with its first or last row.
    for (int k = 0; k < taps; ++k)
      distances[k] = static_cast<float>(std::clamp(v + k - radius, 0, height_px_ - 1) - v);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < taps; ++k) rows[k] = ring_row(c, v + k);
      float* const out = &light[c * stride];
      if (motion.still) {
        kernels.blur_across_rows(rows.data(), kernel_.data(), taps, nullptr, wide, out);
      } else {
        const size_t pixel = static_cast<size_t>(v) * width_px_;
        kernels.moments_across_rows(rows.data(), kernel_.data(), distances.data(), taps, wide,
                                    moments);
        kernels.moving_blur(moments, &motion.shear[pixel], &motion.stretch[pixel],
                            static_cast<float>(optics_.blur_sigma_px), width_px_, out);
      }
    }
    take(v, lights);
  }
}

void CameraFilter::apply(const LinearImage& image, const RowMotion& motion,
                         std::span<const float> lamps, std::vector<float>& illumination) const {
  const FilterKernels& kernels = filter_kernels();
  const size_t row_samples = static_cast<size_t>(width_px_) * 3;
  illumination.resize(row_samples * height_px_);
  blur(image, motion, [&](int row, const float* const* light) {
    kernels.interleave(light, &gain_[row * row_samples], lamps[row], width_px_,
                       &illumination[row * row_samples]);
  });
  if (optics_.glare_fraction > 0) add_glare(illumination);
  for (size_t i = 0; i < own_light_.size(); ++i) illumination[i] += own_light_[i];
}

void CameraFilter::add_glare(std::vector<float>& illumination) const {
  double sum[3] = {0, 0, 0};
  for (size_t i = 0; i < illumination.size(); i += 3) {
    for (int c = 0; c < 3; ++c) sum[c] += illumination[i + c];
  }
  const auto kept = static_cast<float>(1 - optics_.glare_fraction);
  float everywhere[3];
  for (int c = 0; c < 3; ++c) {
    everywhere[c] = static_cast<float>(optics_.glare_fraction * sum[c] /
                                       (static_cast<double>(width_px_) * height_px_));
  }
  filter_kernels().glare(kept, everywhere, illumination.size() / 3, illumination.data());
}

LinearImage CameraFilter::blurred(const LinearImage& image, const RowMotion& motion) const {
  LinearImage result{.width_px = width_px_, .height_px = height_px_};
  for (auto& plane : result.planes) plane.resize(static_cast<size_t>(width_px_) * height_px_);
  blur(image, motion, [&](int row, const float* const* light) {
    for (int c = 0; c < 3; ++c) {
      std::copy_n(light[c], width_px_,
                  result.planes[c].begin() + static_cast<ptrdiff_t>(row) * width_px_);
    }
  });
  return result;
}

}  // namespace seam::render
