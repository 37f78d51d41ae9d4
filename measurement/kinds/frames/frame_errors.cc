#include "measurement/kinds/frames/frame_errors.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace seam::measurement {
namespace {

float smaller_slope(float a, float b) {
  if (a * b <= 0) return 0;
  return std::abs(a) < std::abs(b) ? a : b;
}

// The derivatives along `lines` lines that lie side by side, each of `count` samples that are
// `stride` apart: value at one border of a sample less that at the other. A border's value is taken
// from that of its two samples in which the image is smoother.
void line_slopes(const float* in, size_t lines, size_t count, size_t stride, float* out) {
  if (count < 2) return;
  std::vector<float> slope_here(lines, 0), border_before(in, in + lines);
  for (size_t i = 0; i < count; ++i, in += stride, out += stride) {
    const bool last = i + 1 == count, next_is_inner = i + 2 < count;
    for (size_t k = 0; k < lines; ++k) {
      float border = in[k], slope_next = 0;
      if (!last) {
        const float next = in[k + stride];
        if (next_is_inner) slope_next = smaller_slope(next - in[k], in[k + 2 * stride] - next);
        border = std::abs(slope_here[k]) <= std::abs(slope_next) ? in[k] + slope_here[k] / 2
                                                                 : next - slope_next / 2;
      }
      out[k] = border - border_before[k];
      border_before[k] = border;
      slope_here[k] = slope_next;
    }
  }
}

}  // namespace

ImageSlope image_slope(const std::vector<float>& image, int width_px, int height_px) {
  const auto width = static_cast<size_t>(width_px), height = static_cast<size_t>(height_px);
  ImageSlope slope{std::vector<float>(image.size()), std::vector<float>(image.size())};
  for (size_t v = 0; v < height; ++v)
    line_slopes(&image[v * width * 3], 3, width, 3, &slope.right[v * width * 3]);
  line_slopes(image.data(), width * 3, height, width * 3, slope.down.data());
  return slope;
}

std::vector<float> steepest_nearby(const ImageSlope& slope, int width_px, int height_px) {
  std::vector<float> square(slope.right.size());
  for (size_t i = 0; i < square.size(); ++i)
    square[i] = slope.right[i] * slope.right[i] + slope.down[i] * slope.down[i];
  const auto spread_along = [&](int count, int lines, size_t stride, size_t line_stride) {
    const std::vector<float> was = square;
    for (int line = 0; line < lines; ++line) {
      for (int i = 0; i < count; ++i) {
        for (size_t c = 0; c < 3; ++c) {
          const size_t at = line * line_stride + i * stride + c;
          if (i > 0) square[at] = std::max(square[at], was[at - stride]);
          if (i + 1 < count) square[at] = std::max(square[at], was[at + stride]);
        }
      }
    }
  };
  const size_t row = static_cast<size_t>(width_px) * 3;
  spread_along(width_px, height_px, 3, row);
  spread_along(height_px, width_px, row, 3);
  return square;
}

FrameErrors::FrameErrors(int width_px, int height_px, const effects::SensorChain& chain,
                         std::vector<ImageSlope> slopes, std::vector<char> used,
                         const std::vector<double>& sigma)
    : width_(static_cast<size_t>(width_px)),
      height_(static_cast<size_t>(height_px)),
      samples_(width_ * height_ * 3),
      row_sigma_dn_(chain.row_sigma_dn),
      column_sigma_dn_(chain.column_sigma_dn),
      used_(std::move(used)),
      sigma2_(slopes.size(), 0),
      log_det_(slopes.size(), 0) {
  constexpr double shift2 = kRendererShiftPx * kRendererShiftPx;
  for (size_t k = 0; k < slopes.size(); ++k) {
    const size_t first = k * samples_;
    for (size_t i = 0; i < samples_; ++i) sigma2_[k] += sigma[first + i] * sigma[first + i];
    sigma2_[k] /= static_cast<double>(samples_);
    log_det_[k] += static_cast<double>(height_) *
                   std::log1p(ratio_of(row_sigma_dn_, k) * 3 * static_cast<double>(width_));
    log_det_[k] += static_cast<double>(width_) *
                   std::log1p(ratio_of(column_sigma_dn_, k) * 3 * static_cast<double>(height_));
    Displacement right{.direction = std::move(slopes[k].right)},
        down{.direction = std::move(slopes[k].down)};
    double both = 0;
    for (size_t i = 0; i < samples_; ++i) {
      const auto weight = used_[first + i] ? static_cast<float>(1 / sigma[first + i]) : 0.0f;
      const double x = right.direction[i] *= weight, y = down.direction[i] *= weight;
      right.size2 += x * x, both += x * y;
    }
    const auto overlap = static_cast<float>(right.size2 > 0 ? both / right.size2 : 0);
    for (size_t i = 0; i < samples_; ++i) {
      const double y = down.direction[i] -= overlap * right.direction[i];
      down.size2 += y * y;
    }
    for (auto [axis, displacement] : {std::pair(0, &right), std::pair(1, &down)}) {
      displacement->stretch = 1 + shift2 * displacement->size2;
      log_det_[k] += std::log(displacement->stretch);
      common_size2_[axis] += displacement->size2 / displacement->stretch;
      displacements_[axis].push_back(std::move(*displacement));
    }
  }
  if (!log_det_.empty()) {
    for (const double size2 : common_size2_) log_det_[0] += std::log1p(shift2 * size2);
  }
}

// An offset of relative variance `ratio` that the samples of each row (or column) share.
void FrameErrors::share(std::vector<double>& values, size_t frame, double ratio, bool rows) const {
  if (ratio <= 0) return;
  const size_t units = rows ? height_ : width_, members = (rows ? width_ : height_) * 3;
  const double shrink = 1 - 1 / std::sqrt(1 + ratio * static_cast<double>(members));
  for (size_t unit = 0; unit < units; ++unit) {
    const auto at = [&](size_t k) {
      const size_t place = k / 3;
      return frame * samples_ + (rows ? unit * width_ + place : place * width_ + unit) * 3 + k % 3;
    };
    double mean = 0;
    for (size_t k = 0; k < members; ++k) mean += values[at(k)] / static_cast<double>(members);
    for (size_t k = 0; k < members; ++k) {
      if (used_[at(k)]) values[at(k)] -= shrink * mean;
    }
  }
}

// For S = 1 + s^2 d d', S^-1/2 = 1 - (1 - 1/sqrt(1 + s^2 d'd)) d d' / d'd: first with each frame's
// own displacement, then with the one that all share, whose direction the first step has shortened.
void FrameErrors::whiten(std::vector<double>& values) const {
  for (size_t k = 0; k < log_det_.size(); ++k) {
    share(values, k, ratio_of(row_sigma_dn_, k), true);
    share(values, k, ratio_of(column_sigma_dn_, k), false);
  }
  for (int axis = 0; axis < 2; ++axis) {
    if (!(common_size2_[axis] > 0)) continue;
    std::vector<double> along(log_det_.size(), 0);
    double common = 0;
    for (size_t k = 0; k < log_det_.size(); ++k) {
      const Displacement& displacement = displacements_[axis][k];
      const double* value = &values[k * samples_];
      for (size_t i = 0; i < samples_; ++i) along[k] += displacement.direction[i] * value[i];
      common += along[k] / displacement.stretch;
    }
    const double stretch = 1 + kRendererShiftPx * kRendererShiftPx * common_size2_[axis];
    const double shared = (1 - 1 / std::sqrt(stretch)) * common / common_size2_[axis];
    for (size_t k = 0; k < log_det_.size(); ++k) {
      const Displacement& displacement = displacements_[axis][k];
      if (!(displacement.size2 > 0)) continue;
      const double shrink = 1 / std::sqrt(displacement.stretch);
      const double part = (1 - shrink) * along[k] / displacement.size2 + shared * shrink;
      double* value = &values[k * samples_];
      for (size_t i = 0; i < samples_; ++i) value[i] -= part * displacement.direction[i];
    }
  }
}

}  // namespace seam::measurement
