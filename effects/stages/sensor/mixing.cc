#include "effects/stages/sensor/mixing.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sim_core/base/maths.h"

namespace seam::effects {
namespace {

// Lines of numbers side by side: place i of all of them stands at [i * step, i * step + count).
struct Lines {
  float* first;
  size_t length, step, count;
  float* at(size_t place) const { return first + place * step; }
};

void mix_lines(double weight, const Lines& lines) {
  const auto side = static_cast<float>(weight), middle = static_cast<float>(1 - 2 * weight);
  std::vector<float> before(lines.at(0), lines.at(0) + lines.count), here(lines.count);
  for (size_t i = 0; i < lines.length; ++i) {
    float* const now = lines.at(i);
    const float* const next = lines.at(std::min(i + 1, lines.length - 1));
    for (size_t k = 0; k < lines.count; ++k) {
      here[k] = now[k];
      now[k] = middle * now[k] + side * (before[k] + next[k]);
    }
    before.swap(here);
  }
}

// Gaussian elimination in a matrix of three diagonals.
void unmix_lines(double weight, const Lines& lines) {
  const size_t n = lines.length;
  std::vector<double> above(n);  // What stands above the diagonal once what was below it is gone.
  std::vector<double> before(lines.count, 0);
  for (size_t i = 0; i < n; ++i) {
    // A mirrored edge has its own value for the neighbour that is missing.
    const double edges = (i == 0 ? weight : 0) + (i + 1 == n ? weight : 0);
    const double below = i > 0 ? weight : 0;
    const double pivot = 1 - 2 * weight + edges - (i > 0 ? below * above[i - 1] : 0);
    above[i] = weight / pivot;
    float* const now = lines.at(i);
    for (size_t k = 0; k < lines.count; ++k) {
      before[k] = (now[k] - below * before[k]) / pivot;
      now[k] = static_cast<float>(before[k]);
    }
  }
  for (size_t i = n - 1; i-- > 0;) {
    float* const now = lines.at(i);
    const float* const next = lines.at(i + 1);
    const auto share = static_cast<float>(above[i]);
    for (size_t k = 0; k < lines.count; ++k) now[k] -= share * next[k];
  }
}

// Along rows, then along columns; a direction without a weight stays as it is.
template <class F>
void each_way(const Mixing& weights, const ImageShape& shape, std::span<float> image, const F& f) {
  const auto width = static_cast<size_t>(shape.width_px),
             height = static_cast<size_t>(shape.height_px),
             channels = static_cast<size_t>(shape.channels), row = width * channels;
  for (size_t v = 0; v < height && weights.along_rows != 0; ++v)
    f(weights.along_rows, Lines{&image[v * row], width, channels, channels});
  if (weights.along_columns != 0) f(weights.along_columns, Lines{image.data(), height, row, row});
}

double log_along(double weight, int length) {
  double sum = 0;
  for (int k = 0; k < length; ++k)
    sum += maths::log(1 - 2 * weight + 2 * weight * maths::cos(maths::kPi * k / length));
  return sum / length;
}

}  // namespace

void mix(const Mixing& weights, const ImageShape& shape, std::span<float> image) {
  each_way(weights, shape, image, mix_lines);
}

void unmix(const Mixing& weights, const ImageShape& shape, std::span<float> image) {
  each_way(weights, shape, image, unmix_lines);
}

double mixed_variance(double weight) {
  const double middle = 1 - 2 * weight;
  return middle * middle + 2 * weight * weight;
}

double mixed_correlation(double weight) {
  return 2 * weight * (1 - 2 * weight) / mixed_variance(weight);
}

double mixing_of(double correlation) {
  // The smaller root of (6 c + 4) w^2 - (4 c + 2) w + c.
  const double a = 6 * correlation + 4, b = 4 * correlation + 2;
  return (b - std::sqrt(std::max(0.0, b * b - 4 * a * correlation))) / (2 * a);
}

double unmixed_variance(double weight) {
  // The mean of 1 / (a + b cos x)^2 over all x.
  const double a = 1 - 2 * weight, b = 2 * weight, apart = a * a - b * b;
  return a / (apart * std::sqrt(apart));
}

double unmixed_variance(const Mixing& weights) {
  return unmixed_variance(weights.along_rows) * unmixed_variance(weights.along_columns);
}

double unmixed_correlation(double weight) {
  return -2 * weight / (1 - 2 * weight);
}

double log_mixing(const Mixing& weights, const ImageShape& shape) {
  return log_along(weights.along_rows, shape.width_px) +
         log_along(weights.along_columns, shape.height_px);
}

}  // namespace seam::effects
