// Means over time of samples in cells of light, with the pixels' patterns as random effects.
#include <array>
#include <cmath>
#include <cstdint>

#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"
#include "measurement/kinds/photometry/likelihood/cell_solve.h"

namespace seam::measurement {

void CellLikelihood::add_means() {
  inverse_.resize(sorted_.count());
  for (auto* v : {&weight_, &slope_vector_}) v->assign(entries_.size(), 0);
  loads_.assign(entries_.size(), PatternLoads::Zero());
  for (size_t cell = 0; cell < sorted_.count(); ++cell) {
    const size_t at = cell * levels_;
    for (size_t k = 0; k < levels_; ++k) {
      weight_[at + k] = frames(k) / entry(cell, k).variance;
      const double square = product(cell, k, k);
      total_.chi2 += weight_[at + k] * square;
      score_.square += frames(k) * square;
    }
    if (!pixels_) continue;
    load_patterns(cell);
    if (sorted_.all_products) add_patterns(cell);
  }
  if (pixels_ && !sorted_.all_products) add_patterns_by_sample();
  if (chain_.hot_fraction > 0 || chain_.weak_fraction > 0 || is_structured()) add_structure();
  if (chain_.lamp_sigma > 0 && !is_structured()) add_lamps();
}

// Leaves loads times weights.
void CellLikelihood::load_patterns(size_t cell) {
  const size_t at = cell * levels_;
  for (size_t k = 0; k < levels_; ++k) {
    const PhotometryLevel& level = data_.levels[sums_.present[k]];
    const Entry& own = entry(cell, k);
    loads_[at + k] = pattern_loads(chain_, level, own.offset_slope, own.gain_slope);
  }
  PatternInverse& patterns = inverse_[cell].patterns;
  patterns = pattern_inverse(&loads_[at], &weight_[at], levels_);
  total_.log_det += sorted_.samples[cell] * patterns.log_det;
  for (size_t k = 0; k < levels_; ++k) loads_[at + k] *= weight_[at + k];
}

// `squares`: sums of products of a sample's loads times its residuals.
void CellLikelihood::take_patterns(size_t cell, const Eigen::Matrix3d& squares) {
  total_.chi2 -= inverse_[cell].patterns.core.cwiseProduct(squares).sum();
}

// What the offsets, gains and dark currents of a cell's pixels take out of chi2.
void CellLikelihood::add_patterns(size_t cell) {
  const size_t at = cell * levels_;
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (size_t k = 0; k < levels_; ++k) {
    squares += product(cell, k, k) * loads_[at + k] * loads_[at + k].transpose();
    for (size_t l = 0; l < k; ++l) {
      const Eigen::Matrix3d both = loads_[at + k] * loads_[at + l].transpose();
      squares += product(cell, k, l) * (both + both.transpose());
    }
  }
  take_patterns(cell, squares);
}

// The same where products of all pairs of levels would be too many: from each sample's residuals.
void CellLikelihood::add_patterns_by_sample() {
  const size_t samples = sorted_.of_sample.size(), count = sorted_.count();
  std::array<std::vector<double>, 3> along;
  std::vector<double> loads(entries_.size());
  for (int j = 0; j < 3; ++j) {
    for (size_t at = 0; at < loads.size(); ++at) loads[at] = loads_[at][j];
    along[static_cast<size_t>(j)].assign(samples, 0);
    add_residuals(loads, along[static_cast<size_t>(j)]);
  }
  std::vector<Eigen::Matrix3d> squares(count, Eigen::Matrix3d::Zero());
  for (size_t i = 0; i < samples; ++i) {
    const PatternLoads b(along[0][i], along[1][i], along[2][i]);
    squares[sorted_.of_sample[i]] += b * b.transpose();
  }
  for (size_t cell = 0; cell < count; ++cell) take_patterns(cell, squares[cell]);
}

}  // namespace seam::measurement
