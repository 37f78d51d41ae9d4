// A filter that mixes each pixel with its neighbours: (w, 1 - 2 w, w) along rows and, with another
// w, along columns, each colour by itself; below 0 it sharpens. The image goes on mirrored beyond
// its edges, so that sums over it stay and cosine waves keep their shape: wave k of n is multiplied
// by 1 - 2 w + 2 w cos(pi k / n).
#pragma once

#include <span>

namespace seam::effects {

struct ImageShape {
  int width_px = 0, height_px = 0, channels = 1;
};

struct Mixing {
  double along_rows = 0, along_columns = 0;  // Weights of a neighbour.
  bool acts() const { return along_rows != 0 || along_columns != 0; }
  bool operator==(const Mixing&) const = default;
};

void mix(const Mixing& weights, const ImageShape& shape, std::span<float> image);
// The inverse. It amplifies errors of single values (`unmixed_variance`).
void unmix(const Mixing& weights, const ImageShape& shape, std::span<float> image);

// The weight up to which it does so by less than 7 in variance in each direction; at 0.25 there is
// no inverse.
inline constexpr double kMostMixing = 0.2;

// Along one direction: which part of the variance of independent noise the filter leaves, how
// neighbours correlate then, by which weight they correlate so, and the variance that the inverse
// makes of independent errors of 1.
double mixed_variance(double weight);
double mixed_correlation(double weight);
double mixing_of(double correlation);
double unmixed_variance(double weight);
// Of both directions.
double unmixed_variance(const Mixing& weights);
// How neighbours among these correlate, along one.
double unmixed_correlation(double weight);
// Logarithm of the filter's determinant, for each sample.
double log_mixing(const Mixing& weights, const ImageShape& shape);

}  // namespace seam::effects
