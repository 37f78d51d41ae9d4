// What a search looked for beside the catalogue's effects of the mean, and what came of it: one
// list for JSON, page and terminal. `adequate` means that none of it was found.
#pragma once

#include <string>
#include <vector>

#include "measurement/search/search.h"

namespace seam::measurement {

struct LookedFor {
  std::string what;                     // "smooth function", "formula", "mixture", ...
  std::vector<std::string> covariates;  // Of which, or the effect's name.
  std::string outcome;                  // "nothing", "trace", "found" or "not tested".
  std::string why;                      // Why it was not tested, or what was found of it.
};

std::vector<LookedFor> looked_for(const Problem& problem, const SearchResult& result);

// A line or two: what was found, in how many cases nothing was, and what was not tested.
std::string looked_for_text(const std::vector<LookedFor>& list);

}  // namespace seam::measurement
