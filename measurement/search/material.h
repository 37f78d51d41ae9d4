// Significant is not material: with many observations every model is wrong significantly. What
// counts is what changes predictions by some share of the noise, root mean square over held-out
// observations (docs/definitions.md, "material").
#pragma once

#include <string>
#include <vector>

#include "measurement/search/assess.h"

namespace seam::measurement {

// By how many noise units the predictions of `after` differ from those of `before`, each with the
// best nuisances: the root mean square over held-out observations, of the channel that moves most;
// and of the standard deviations in the same units. An effect of spread moves these alone. Kinds
// without residuals of their own (sufficient statistics) tell it from the likelihood: n
// observations that move by d gain n d^2 / 2, those whose standard deviation changes by the share s
// gain n s^2.
double movement(const Problem& problem, const Assessment& before, const Assessment& after,
                bool spread_only);

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
