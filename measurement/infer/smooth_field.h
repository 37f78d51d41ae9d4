// A smooth function of one or two covariates, added to what a model predicts: an unnamed cause. It
// is a random effect: columns whose coefficients are normal, slow waves larger than fast ones.
// Of a wave of order k the variance falls as k^-2, as of a random walk, or as k^-4, as of the cubic
// splines that smooth best (Wahba 1990): a wave that is added to a trend, or a trend alone.
#pragma once

#include <string>
#include <vector>

#include "measurement/problem/problem.h"

namespace seam::measurement {

struct SmoothField {
  const FieldPlace* place = nullptr;
  std::vector<const Covariate*> covariates;  // Of the place: one or two.
};

// The channels of a set, and what is made of two of them (along and across), by its covariates.
std::vector<FieldPlace> places_in_channels(const Problem& problem, const Evaluation& here);

// All fields in these places: of each covariate that is a quantity, and of each pair.
std::vector<SmoothField> smooth_fields(const std::vector<FieldPlace>& places);

// Of its covariates, with "view" behind them where each view has its own.
std::vector<std::string> names_of(const SmoothField& field);

// By column and scalar, of residuals over sigma, as the slopes of the place are.
struct FieldColumns {
  // Of a size that moves residuals by about the noise where coefficients are 1, for variances that
  // fall as k^-2. Empty: a covariate is constant or unknown in some row.
  std::vector<std::vector<double>> values;
  std::vector<double> smoother;  // Spread of each coefficient where they fall as k^-4.
};
FieldColumns columns_of(const Facts& facts, const SmoothField& field);

}  // namespace seam::measurement
