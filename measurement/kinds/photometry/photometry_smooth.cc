#include "measurement/kinds/photometry/photometry_smooth.h"

#include "measurement/kinds/photometry/structure/photometry_mean_tests.h"
#include "measurement/numerics/legendre.h"
#include "measurement/numerics/linear_algebra.h"

namespace seam::measurement {

SmoothField::SmoothField(const PhotometryData& data) : channels_(data.channels) {
  constexpr int kOrder = 3, kFunctions = (kOrder + 1) * (kOrder + 2) / 2;
  basis_.resize(static_cast<Eigen::Index>(data.width_px) * data.height_px, kFunctions);
  Eigen::Index pixel = 0;
  for (int v = 0; v < data.height_px; ++v) {
    for (int u = 0; u < data.width_px; ++u, ++pixel) {
      const SamplePlace place = place_of(data, 0, u, v, 0);
      Eigen::Index at = 0;
      for (int i = 0; i <= kOrder; ++i)
        for (int k = 0; i + k <= kOrder; ++k)
          basis_(pixel, at++) = legendre(i, place.x) * legendre(k, place.y);
    }
  }
  inverse_ = pseudo_inverse(basis_.transpose() * basis_);
}

std::vector<double> SmoothField::of(const std::vector<double>& value) const {
  std::vector<double> out(value.size());
  for (int c = 0; c < channels_; ++c) {
    Eigen::VectorXd own(basis_.rows());
    for (Eigen::Index i = 0; i < own.size(); ++i)
      own[i] = value[static_cast<size_t>(i * channels_ + c)];
    const Eigen::VectorXd smooth = basis_ * (inverse_ * (basis_.transpose() * own));
    for (Eigen::Index i = 0; i < own.size(); ++i)
      out[static_cast<size_t>(i * channels_ + c)] = smooth[i];
  }
  return out;
}

}  // namespace seam::measurement
