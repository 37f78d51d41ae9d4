// Effects that might be missing: each is fitted beside what the model has, and compared.
#pragma once

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
  double p_value = 1;        // Likelihood ratio, corrected for the number of candidates.
  double merit = 0;          // Total log-likelihood less a price for each parameter needed.
  bool at_bound = false;
  bool significant = false;
  std::vector<std::string> indistinguishable_from;
};

struct Looks {
  std::vector<Candidate> candidates;  // Best first.
  std::vector<NotTestable> not_testable;
};

// False alarms are designed for 1 % a set: half for candidates, half for structure tests.
inline constexpr double kCandidateAlarm = 0.005;
inline constexpr double kStructureAlarm = 0.005;

// The effects of the catalogue that act on this set, and the user's own, less those in the model.
EffectList absent_effects(const Problem& problem, const Model& model, const EffectList& own);

// Fits every effect of the list beside the model.
Looks look_at(const Problem& problem, const Grown& base, const EffectList& effects);

// Fits one effect beside the model. Nothing where it cannot be tested (and says why in `reasons`).
std::optional<Candidate> try_effect(const Problem& problem, const Grown& base,
                                    const std::shared_ptr<const EffectDefinition>& effect,
                                    std::vector<NotTestable>& reasons);

// Fills p-value and merit of a candidate against what it grew from.
void judge(const Problem& problem, const Grown& base, double looks, Candidate& candidate);

// Best first: merit, then by preference among ties; fills `indistinguishable_from`.
void rank_candidates(std::vector<Candidate>& candidates);

// The log-likelihood below which two explanations count as equally good.
double tie_width(double error);

// Total log-likelihood less the price of the parameters that the added effects need.
double merit_of(const Problem& problem, const Grown& grown);

}  // namespace seam::measurement
