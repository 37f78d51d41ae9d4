// What a whole search found, in order: its steps, and the candidates beside the model given.
#pragma once

#include <string>
#include <vector>

#include "measurement/search/exchanges.h"
#include "measurement/search/search.h"

namespace seam::measurement {

// The steps from the base to the best model, in the order in which each effect helps most, with
// those of the promising effects that could stand in the place of each.
void order_steps(const Problem& problem, const EffectByName& effect_by_name,
                 const Exchanges& exchanges, const std::vector<std::string>& promising,
                 SearchResult& result);

// The steps that are noises: what has a name comes before any formula.
std::vector<std::string> noises_found(const SearchResult& result);
// Of these, those that are described by their size and length alone: noise of unknown cause.
std::vector<std::string> noises_of_unknown_cause(const SearchResult& result);
// Whether they are all that the model lacked.
bool explained_by_noises(const SearchResult& result);

// Puts the effects of the final model first, in the order of its steps, and says of the others
// which of these they stand in for: alone they seemed to help, beside them they do not.
void rank_by_search(const Problem& problem, SearchResult& result);

// The best cause without a name beside one of these models, each of which grew from the one before.
std::optional<UnnamedCause> unnamed_beside(const Problem& problem, const std::vector<Grown>& grown,
                                           double material);

// A smooth function of what residuals may depend on competes with the steps. Where it explains the
// set better beside some of them, the others imitate it: they are steps no more.
void look_for_unnamed(const Problem& problem, SearchResult& result);

}  // namespace seam::measurement
