// What comes out when a model is held against a measurement set: residuals, scores, fits,
// structures.
//
// Vectors over scalars always have the length of all scalars; entries outside the chosen groups, or
// left out as outliers, have `used` 0.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "effects/model.h"
#include "measurement/problem/facts.h"

namespace seam::measurement {

using effects::Model;

// A parameter that a fit may change.
struct Unknown {
  std::string effect;
  size_t parameter = 0;
};

// Residuals of a model with the best nuisances (unknown poses, true starts of runs).
struct Evaluation {
  std::vector<char> used;        // By scalar.
  std::vector<double> residual;  // Observed - predicted, in the channel's unit.
  std::vector<double> whitened;  // L^-1 residual with S = L L' = set noise + model noise effects.
  std::vector<double> sigma;     // By scalar: square root of the diagonal of S.
  std::vector<double> log_det;   // By group: log det S (groups are independent of each other).
  int64_t nuisances = 0;         // Fitted on these groups.
  std::vector<double> nuisance_values;  // For a warm start; layout is the kind's own.
  bool valid = true;  // False where the model cannot predict an observation (no image point).
  // For a kind's own use: what it need not compute again from a warm start. `mean_key` holds the
  // parameters of the mean; `reusable` may lag behind them (a fit evaluates afresh between rounds).
  std::vector<double> mean_key;
  std::shared_ptr<const void> reusable;
};

// The parameters of a model that act on the mean, in order.
std::vector<double> mean_parameters(const Model& model);

// How well a model does on some groups.
struct Score {
  double chi2 = 0;  // r' S^-1 r.
  int64_t n = 0;    // Residuals.
  int64_t nuisances = 0;
  double log_likelihood = 0;
  std::vector<double> by_group;     // Log-likelihood of each group; 0 outside the chosen ones.
  std::vector<double> native;       // By channel: plain root mean square of the residuals.
  std::vector<double> native_sum2;  // By channel, so that folds can be pooled.
  std::vector<int64_t> native_count;
  bool valid = true;

  double error() const;
};

struct Fit {
  Model model;                // At the estimate; sigmas of the unknowns are not written into it.
  std::vector<double> value;  // By unknown.
  std::vector<double> sigma;  // By unknown; infinite where the data say nothing of it.
  std::vector<char> at_bound;
  std::vector<double> covariance;  // Row-major, unknowns x unknowns.
  double log_likelihood = 0;       // On the fitted groups.
  bool converged = false;
};

// A structure of the residuals that should not be there.
struct Structure {
  std::string residual;   // Channel.
  std::string moment;     // mean | spread
  std::string covariate;  // row*pan_rate
  double strength = 0;    // Root mean square of the explained part, in the residual's unit.
  double p_value = 1;     // Corrected for the number of looks.
  double explained = 0;   // Share of the residual's sum of squares.
};

// The noise of a residual's channel, or of the first of the two that a combined one is made of.
double noise_of(const Facts& facts, const std::string& residual);

// Surest first. Values of p that are cut (1e-300) are no order: of these, and of equals, the one
// that is stronger in units of its channel's noise goes first.
void strongest_first(const Facts& facts, std::vector<Structure>& structures);

struct Outlier {
  int line = 0;
  size_t scalar = 0;
  double residual = 0;
};

}  // namespace seam::measurement
