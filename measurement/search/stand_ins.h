// The candidates beside the model given, ordered by what the whole search shows.
#pragma once

#include "measurement/search/search.h"

namespace seam::measurement {

// Puts the effects of the final model first, in the order of its steps, and says of the others
// which of these they stand in for: alone they seemed to help, beside them they do not.
void rank_by_search(const Problem& problem, SearchResult& result);

}  // namespace seam::measurement
