// What comes out when a model is held against a measurement set: residuals, scores, fits,
// structures.
//
// Vectors over scalars always have the length of all scalars; entries outside the chosen groups, or
// left out as outliers, have `used` 0.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "effects/model.h"
#include "measurement/problem/facts.h"

namespace seam::measurement {

using effects::Model;

// A parameter that a fit may change.
struct Unknown {
  std::string effect;
  size_t parameter = 0;

  bool operator==(const Unknown&) const = default;
};

// Its place among these, if it is there.
std::optional<size_t> index_of(const std::vector<Unknown>& unknowns, const Unknown& which);

// Residuals of a model with the best nuisances (unknown poses, true starts of runs).
struct Evaluation {
  std::vector<char> used;        // By scalar.
  std::vector<double> residual;  // Observed - predicted, in the channel's unit.
  // L^-1 residual with S = L L' = set noise + model noise effects. Beyond the scalars stand draws
  // that are estimated with them (displaced points of a target) over their own spreads: they count
  // into chi-square and likelihood as residuals do, but belong to no row.
  std::vector<double> whitened;
  std::vector<double> sigma;    // By scalar: square root of the diagonal of S.
  std::vector<double> log_det;  // By group: log det S (groups are independent of each other).
  double shared_log_det = 0;    // The part of log det S that is no single group's.
  double absorbed = 0;          // Freedom of the residuals that estimated draws take.
  // Where errors are not normal, `whitened` is the signed root of twice what the residual costs: by
  // scalar the mean of its square and its mean (noise/few_errors.h). Empty: 1, and 0.
  std::vector<double> mean_square, mean_whitened;
  // Its size there, of what is left out as well, by which outliers are told; infinite for scalars
  // with normal errors.
  std::vector<double> deviance;
  int64_t nuisances = 0;                // Fitted on these groups.
  std::vector<double> nuisance_values;  // For a warm start; layout is the kind's own.
  bool valid = true;  // False where the model cannot predict an observation (no image point).
  // For a kind's own use: what it need not compute again from a warm start. `mean_key` holds the
  // parameters of the mean; `reusable` may lag behind them (a fit evaluates afresh between rounds).
  std::vector<double> mean_key;
  std::shared_ptr<const void> reusable;

  // A whitened residual less what the model expects of it.
  double beyond_mean(size_t scalar) const {
    return whitened[scalar] - (mean_whitened.empty() ? 0 : mean_whitened[scalar]);
  }
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
  std::vector<double> by_block;     // The same of each block, where groups are few.
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
  double strength = 0;    // Root mean square of what is explained beyond chance, in its unit.
  double p_value = 1;     // Corrected for the number of looks.
  double explained = 0;   // Share of the residual's sum of squares, likewise.
};

// The noise of a residual's channel, or of the first of the two that a combined one is made of.
double noise_of(const Facts& facts, const std::string& residual);

// Whether a covariate of the set is one of labels.
bool is_label(const Facts& facts, const std::string& covariate);

// Tests of structure give what is at least as sure, corrected for the number of looks; which of it
// counts is judged later.
inline constexpr double kLeastSure = 0.05;
// Smaller values of p are cut to this one.
inline constexpr double kLeastP = 1e-300;

// Surest first. Values of p that are cut are no order: of these, and of equals, the one
// that is stronger in units of its channel's noise goes first.
void strongest_first(const Facts& facts, std::vector<Structure>& structures);

// An error in its own unit of predictions that no measured value on their way corrects.
struct FreeError {
  std::string over;      // How far they reach: "1 s", "run".
  std::string residual;  // position_m
  double rms = 0;
  double last = 0;    // Root mean square at their ends alone.
  int64_t count = 0;  // Of predictions.
};

// What a model and the data say together that no parameter holds: where a landmark lies.
struct Finding {
  std::string what;  // landmark
  std::string name;
  std::vector<std::pair<std::string, double>> values;
  std::string text;  // A sentence.
};

// A point of a target as a model places it.
struct PlacedPoint {
  std::string name;
  Vec3 plan_m{0.0};   // Where the set has it,
  Vec3 place_m{0.0};  // and where the model does, in the same axes.
  Vec3 shift_m{0.0};  // From one to the other along the target's own axes, the last out of a board.
  Vec3 sigma_m{0.0};  // Of the shift; 0 where no displacement of its own is estimated.
};

struct Outlier {
  int line = 0;
  size_t scalar = 0;
  double residual = 0;
};

}  // namespace seam::measurement
