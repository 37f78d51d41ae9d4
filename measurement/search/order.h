// What a whole search found, in order: its steps, and the candidates beside the model given.
#pragma once

#include <string>
#include <vector>

#include "measurement/search/exchanges.h"
#include "measurement/search/search.h"

namespace seam::measurement {

// The steps from the base to the best model, in the order in which each effect helps most.
void order_steps(const Problem& problem, const EffectByName& effect_by_name, SearchResult& result);

// Which of the promising effects could stand in the place of each step: as likely ones, and those
// that predict the same as far as predictions are exact. `searched` is the model that the steps
// were put in order from. Where material structure of the mean is left beside all steps, or a cause
// without a name, neither a step nor what could stand for it is established: no tie is looked for.
void tell_ties(const Problem& problem, const EffectByName& effect_by_name,
               const Exchanges& exchanges, const Grown& searched,
               const std::vector<std::string>& promising, SearchResult& result);

// The steps that are noises.
std::vector<std::string> noises_found(const SearchResult& result);
// Of these, those that are described by their size and length alone: noise of unknown cause.
std::vector<std::string> noises_of_unknown_cause(const SearchResult& result);
// Whether noises are all that the model lacked.
bool explained_by_noises(const SearchResult& result);

// Tests the structure of the residuals of the best model, and says what it and the model given,
// whose structure is `of_base`, leave.
void give_verdict(const Problem& problem, const SplitStructure& of_base, SearchResult& result);

// Puts the effects of the final model first, in the order of its steps, and says of the others
// which of these they stand in for: alone they seemed to help, beside them they do not.
void rank_by_search(const Problem& problem, SearchResult& result);

}  // namespace seam::measurement
