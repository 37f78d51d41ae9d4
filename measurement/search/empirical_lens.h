// The lens that all others are held against: where smooth functions of the place in the image
// explain what no lens with a formula does, a smooth lens of splines is fitted, and says how much
// every such formula leaves.
#pragma once

#include "measurement/search/search.h"

namespace seam::measurement {

// Fits it beside what is left of the steps, or beside all that the search had found, whichever
// explains more; `result.splines` holds it where its log-evidence is ahead of `searched`, the best
// explanation by named effects alone, and held-out groups agree that what all formulas leave is
// material.
void hold_against_splines(const Problem& problem, const Progress& progress, const Grown& searched,
                          SearchResult& result);

}  // namespace seam::measurement
