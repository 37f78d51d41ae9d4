// What the search does next, by what it has looked at, and what goes again.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "measurement/search/candidates.h"
#include "measurement/search/exchanges.h"

namespace seam::measurement {

// The best candidate, unless it is one of spread beside a model that misses more than the noise,
// while one of the mean lowers the residuals themselves: a spread wide enough hides any structure
// of the mean. One that only does that is no candidate.
Candidate* choose(const Problem& problem, const Grown& here, std::vector<Candidate>& candidates);

// The same, it and what may be tied with it fitted to all rows, where a look asked few groups.
Candidate* choose_by_all_rows(const Problem& problem, const Grown& here, double material,
                              Looks& looks);

// Whether an added effect is so far from neutral in its first fitted parameter, its size, that it
// cannot go: a shortcut.
bool clearly_needed(const Grown& grown, const std::string& name);

// A model less one of its added effects, not fitted again.
Grown without(const Grown& grown, const std::string& out);

// Drops, one after the other, the effects added that are not needed beside the rest, fitted again
// without them, as a search judges that has looked at so many. Returns whether any went.
bool prune(const Problem& problem, const EffectByName& definition, double looks, double material,
           Grown& grown);

// Whether an added effect is no result: the values that lie within kWithinError of their errors of
// neutral leave nothing of it once they are there. `stated` has the errors that the user sees.
bool is_at_neutral(const Problem& problem, const Assessment& stated, const std::string& name);

// Removes the added effects that are no results, one by one, the rest fitted again. Returns whether
// any went.
bool remove_neutral(const Problem& problem, Grown& grown);

}  // namespace seam::measurement
