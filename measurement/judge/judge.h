// When an effect counts as found: likelihood ratios corrected for the number of looks, the
// agreement of groups that were held out, and which of several explanations comes first.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "measurement/fitting/assess.h"
#include "measurement/judge/decisions.h"

namespace seam::measurement {

using EffectList = std::vector<std::shared_ptr<const EffectDefinition>>;

// A model that grew from the one given by the user: the effects added so far and how it does.
struct Grown {
  std::vector<std::string> added;
  Assessment assessment;
};

struct Candidate {
  std::shared_ptr<const EffectDefinition> effect;
  Grown grown;               // The model with it.
  EffectList companions;     // Added with it, as one move.
  std::vector<size_t> free;  // Its parameters that were fitted.
  bool of_few = false;       // Fitted to a few groups alone, and held against all.
  double most_ll = 0;        // Total log-likelihood that a fit to all rows may reach.
  double gain_ll = 0;        // Held-out log-likelihood gained.
  double total_gain_ll = 0;  // Of training and held-out groups together.
  double held_z = 0;         // gain_ll over its standard error, from the scatter between groups.
  double p_value = 1;        // Likelihood ratio, corrected for the number of candidates.
  double merit = 0;          // Log-evidence (evidence.h).
  bool at_bound = false;
  bool significant = false;  // And material: the search goes by both.
  bool trace = false;        // Significant, but not material.
  bool hides_mean = false;   // It would be, but calls a mean noise.
  double moved = 0;          // Noise units, where it is significant.
  double fall = 0;           // Of held-out residuals in their own units: a share.
  std::vector<std::string> indistinguishable_from;
  bool found = false;                      // It is in the model that the search ended with.
  std::vector<std::string> stands_in_for;  // Effects found that explain what it seemed to.
};

// Whether a parameter of the effect is a whole number: it is tried, not fitted.
bool has_counts(const EffectDefinition& effect);

// Fills p-value and merit of a candidate against what it grew from. `material` is the least change
// of predictions that counts, in noise units; `here` is the base's evaluation on the scored groups.
void judge(const Problem& problem, const Grown& base, const Evaluation& here, double looks,
           double material, Candidate& candidate);

// Sum of the held-out groups' gains over its standard error, by their blocks where groups are fewer
// than this; 0 with fewer than three of either.
double gain_over_scatter(const Score& before, const Score& after,
                         size_t fewest_groups = kLeastGroupsForScatter);
// The same of the roots of gains: a gain grows as the square of what moves, so that groups that
// move unlike amounts by one law agree in their roots. Groups that hardly gain or lose say nothing.
double root_gain_over_scatter(const Score& before, const Score& after,
                              size_t fewest_groups = kLeastGroupsForScatter);

// Whether an effect changes the spread of observations and no prediction.
bool only_widens(const EffectDefinition& effect);

// Whether an effect of the mean, found beside a base that misses more than the noise, lowers the
// residuals in their own units by enough to be heard before any spread.
bool goes_before_spreads(const Candidate& candidate);

// Best first, by evidence; names for each, in `indistinguishable_from`, those that the data cannot
// tell from it.
void rank_candidates(std::vector<Candidate>& candidates);

// Those that are significant but not material.
std::vector<Candidate> traces_of(const std::vector<Candidate>& candidates);
// Adds a name that the list lacks.
void add_once(std::vector<std::string>& names, const std::string& name);
// Adds the names of those that are significant, as long as there are few.
void remember_significant(const std::vector<Candidate>& candidates,
                          std::vector<std::string>& names);

// The log-likelihood below which two explanations count as equally good.
double tie_width(double error);

// Whether the data cannot tell apart two explanations with these log-likelihoods, where the better
// one leaves this error.
bool cannot_tell(double log_likelihood, double other, double error);

// Parameters that were fitted of a candidate and its companions.
size_t fitted_parameters(const Candidate& candidate);

// Its log-evidence: what explanations are compared by.
double merit_of(const Grown& grown);

}  // namespace seam::measurement
