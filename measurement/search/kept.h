// Traces that stay in the model though they are no steps. What changes predictions by less than a
// tenth of the noise may change values of the model by many of their errors: photon noise takes
// over the variance of a pattern that is left out, and is told with an error that knows of none.
#pragma once

#include <optional>
#include <string>

#include "measurement/search/search.h"

namespace seam::measurement {

// The value that two fits of one model, one with an effect more, differ most about.
struct Moved {
  Unknown value;
  double errors = 0;  // By so many of those that the first fit states.
};
Moved most_moved(const Assessment& without, const Assessment& with);

// The trace fitted beside a model; nothing where it is none any more, or gains nothing. `looks` as
// `judge` asks.
std::optional<Candidate> fitted_beside(const Problem& problem, const Grown& grown,
                                       const Candidate& trace, double looks, double material);

// Fits those traces of the last look beside the best model that move a value by more than
// kToldWrong of its errors, the worst first, each beside those before it.
void keep_traces(const Problem& problem, double looks, SearchResult& result);

// The value that a trace which was kept moves most, as effect.parameter.
std::string moved_value(const SearchResult& result, const KeptTrace& kept);

}  // namespace seam::measurement
