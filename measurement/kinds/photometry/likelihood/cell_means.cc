// Means over time of samples in cells of light, with the pixels' patterns as random effects.
#include <cmath>
#include <cstdint>

#include "measurement/kinds/photometry/likelihood/cell_likelihood.h"
#include "measurement/kinds/photometry/likelihood/cell_solve.h"

namespace seam::measurement {

void CellLikelihood::add_means() {
  inverse_.resize(sorted_.count());
  for (auto* v : {&weight_, &offset_load_, &gain_load_, &slope_vector_})
    v->assign(entries_.size(), 0);
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
    offset_load_[at + k] = chain_.pixel_offset_sigma_dn * entry(cell, k).offset_slope;
    gain_load_[at + k] = chain_.pixel_gain_sigma * entry(cell, k).gain_slope;
  }
  PatternInverse& two = inverse_[cell].two;
  two = pattern_inverse(&offset_load_[at], &gain_load_[at], &weight_[at], levels_);
  total_.log_det += sorted_.samples[cell] * two.log_det;
  for (size_t k = 0; k < levels_; ++k)
    offset_load_[at + k] *= weight_[at + k], gain_load_[at + k] *= weight_[at + k];
}

void CellLikelihood::take_patterns(size_t cell, double q00, double q01, double q11) {
  const PatternInverse& two = inverse_[cell].two;
  total_.chi2 -= two.i00 * q00 + 2 * two.i01 * q01 + two.i11 * q11;
}

// What the offsets and gains of a cell's pixels take out of chi2.
void CellLikelihood::add_patterns(size_t cell) {
  const size_t at = cell * levels_;
  double q00 = 0, q01 = 0, q11 = 0;
  for (size_t k = 0; k < levels_; ++k) {
    for (size_t l = 0; l <= k; ++l) {
      const double both = (k == l ? 1 : 2) * product(cell, k, l);
      q00 += both * offset_load_[at + k] * offset_load_[at + l];
      q01 +=
          0.5 * both *
          (offset_load_[at + k] * gain_load_[at + l] + offset_load_[at + l] * gain_load_[at + k]);
      q11 += both * gain_load_[at + k] * gain_load_[at + l];
    }
  }
  take_patterns(cell, q00, q01, q11);
}

// The same where products of all pairs of levels would be too many: from each sample's residuals.
void CellLikelihood::add_patterns_by_sample() {
  const size_t samples = sorted_.of_sample.size(), count = sorted_.count();
  std::vector<double> b0(samples, 0), b1(samples, 0);
  add_residuals(offset_load_, b0);
  add_residuals(gain_load_, b1);
  std::vector<double> q00(count, 0), q01(count, 0), q11(count, 0);
  for (size_t i = 0; i < samples; ++i) {
    const size_t cell = sorted_.of_sample[i];
    q00[cell] += b0[i] * b0[i], q01[cell] += b0[i] * b1[i], q11[cell] += b1[i] * b1[i];
  }
  for (size_t cell = 0; cell < count; ++cell) take_patterns(cell, q00[cell], q01[cell], q11[cell]);
}

}  // namespace seam::measurement
