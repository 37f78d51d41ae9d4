// Significant is not material: with many observations every model is wrong significantly. What
// counts is what changes predictions by some share of the noise, root mean square over held-out
// observations (docs/reference/definitions.md, "material").
#pragma once

#include <string>
#include <vector>

#include "measurement/fitting/assess.h"

namespace seam::measurement {

// What an effect changes, on held-out observations.
struct Change {
  // By how many noise units predictions differ, each with the best nuisances: the root mean square,
  // of the channel that moves most; and standard deviations in the same units. An effect of spread
  // moves these alone. Kinds without residuals of their own (sufficient statistics) tell it from
  // the likelihood: n observations that move by d gain n d^2 / 2, those whose standard deviation
  // changes by the share s gain n s^2.
  double moved = 0;
  // Whether the channels whose standard deviations change end at the noise: a spread that is there
  // leaves nothing else in them, one that only stands for a misfit leaves residuals that are no
  // noise of this size.
  bool at_noise = true;
};
// `here` is that of `before` on the scored groups: evaluate it once for many `after`.
Change change_by(const Problem& problem, const Evaluation& here, const Assessment& before,
                 const Assessment& after, bool spread_only);

// So far from 1 a root mean square of n values at the noise is not by chance: kMisfit, and more
// where they are few.
double limit_at_noise(double n);

// By which share held-out residuals fall in their own units, the mean over observations: what an
// effect of the mean gains whatever the noise is. Negative where they grow.
double native_fall(const Score& before, const Score& after);

// Whether a spread, wide as the residuals are, only stands for a mean: of what it calls noise a
// function of some covariate explains a good part, or a small one where the model before misses by
// far more than the noise.
bool hides_mean(const Problem& problem, const Assessment& before, const Assessment& with_spread);

// The strength of a structure in units of its channel's noise; a channel without a stated noise has
// what the model says of it, its residuals over the error.
double noise_units(const Problem& problem, const Assessment& assessment,
                   const Structure& structure);

// Structures that are significant, those that matter apart from traces.
struct SplitStructure {
  std::vector<Structure> material;
  std::vector<Structure> traces;
};
SplitStructure significant_structure(const Problem& problem, const Assessment& assessment,
                                     double material);

bool has_mean_structure(const std::vector<Structure>& structure);

}  // namespace seam::measurement
