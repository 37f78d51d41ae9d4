// Effects that might be missing: each is fitted beside what the model has, and compared.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measurement/assess.h"

namespace seam::measurement {

using EffectList = std::vector<std::shared_ptr<const EffectDefinition>>;

struct NotTestable {
  std::string effect;
  std::string parameter;  // Empty: the whole effect.
  std::string why;
};

// A model that grew from the one given by the user: the effects added so far and how it does.
struct Grown {
  std::vector<std::string> added;
  Assessment assessment;
};

struct Candidate {
  std::shared_ptr<const EffectDefinition> effect;
  Grown grown;               // The model with it.
  std::vector<size_t> free;  // Its parameters that were fitted.
  double gain_ll = 0;        // Held-out log-likelihood gained.
  double total_gain_ll = 0;  // Of training and held-out groups together.
  double held_z = 0;         // gain_ll over its standard error, from the scatter between groups.
  double p_value = 1;        // Likelihood ratio, corrected for the number of candidates.
  double merit = 0;          // Total log-likelihood less a price for each parameter needed.
  bool at_bound = false;
  bool significant = false;
  std::vector<std::string> indistinguishable_from;
};

struct Looks {
  std::vector<Candidate> candidates;  // Best first.
  std::vector<NotTestable> not_testable;
  double tried = 0;  // Effects that were looked at, for the correction of p-values.
};

// False alarms are designed for 1 % a set: half for candidates, half for structure tests.
inline constexpr double kCandidateAlarm = 0.005;
inline constexpr double kStructureAlarm = 0.005;
// An error above this is no sampling error of a model that lacks nothing.
inline constexpr double kMisfit = 1.15;
// A model above this explains nothing yet.
inline constexpr double kUseless = 10;

// The effects of the catalogue that act on this set, and the user's own, less those in the model.
EffectList absent_effects(const Problem& problem, const Model& model, const EffectList& own);

// What one linearisation says of an effect beside a model, before anything is fitted.
struct Prospect {
  std::shared_ptr<const EffectDefinition> effect;
  std::vector<std::vector<double>> starts;
  std::vector<size_t> free;  // Its parameters that the data can see.
  // Total log-likelihood after one step of Gauss and Newton in all unknowns (the score test);
  // infinite where such a step says nothing: spreads, counts, servos, replacements.
  double expected_ll = std::numeric_limits<double>::infinity();
};

// Nothing where the effect cannot be tested (and says why in `reasons`).
std::optional<Prospect> prospect_of(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons);

// Fits a prospect beside the model it was seen with.
std::optional<Candidate> fit_prospect(const Problem& problem, const Grown& base,
                                      const Prospect& prospect, std::vector<NotTestable>& reasons);

// Both in one.
std::optional<Candidate> try_effect(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons);

// Fits every effect of the list beside the model. With `promising_only` or where predictions are
// dear (screening_groups), and where the problem is smooth, those whose score test says that they
// would not be significant are left out, of the others the best few are fitted, and spreads only
// where no effect of the mean clearly helps.
Looks look_at(const Problem& problem, const Grown& base, const EffectList& effects,
              bool promising_only = false);

// Fills p-value and merit of a candidate against what it grew from.
void judge(const Problem& problem, const Grown& base, double looks, Candidate& candidate);

// Sum of the held-out groups' gains over its standard error; 0 with fewer than three groups.
double gain_over_scatter(const Score& before, const Score& after);

// Whether an effect of the mean helps in most held-out groups, not by the luck of a few: what
// moves whole groups (jitter) lets other effects seem to help.
bool clearly_helps(const Candidate& candidate);

// Best first: merit, then by preference among ties; fills `indistinguishable_from`.
void rank_candidates(std::vector<Candidate>& candidates);

// The log-likelihood below which two explanations count as equally good.
double tie_width(double error);

// Total log-likelihood less the price of the parameters that the added effects need.
double merit_of(const Problem& problem, const Grown& grown);

}  // namespace seam::measurement
